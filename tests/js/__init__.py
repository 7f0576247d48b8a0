"""The page's modules in Node.js: alone in *.test.js, compared with engine and server in test_*.py."""
