"""The HTTP and WebSocket interface, one module a subject. Routes carry out; others decide."""
