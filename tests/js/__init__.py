"""The page's scripts in Node.js: alone in *.test.js, held to engine and server in test_*.py."""
