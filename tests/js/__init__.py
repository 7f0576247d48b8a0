"""The page's modules in Node.js: alone in *.test.js, compared with the server in test_*.py."""
