"""The page's scripts in Node.js: unit tests in *.test.js, comparisons with Python in test_*.py."""
