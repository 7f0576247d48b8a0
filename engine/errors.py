"""The engine's error tree. Every message names the bad value and what would be right.

EngineError (a ValueError)
├── BoardError        a board that cannot be played; `field` says where
├── SeedError         not an integer 0 <= seed < 2^64
├── EffortError       it takes more computing than a call may
├── ParameterError    a solver's or a drop's parameter out of range; `field` says which
├── RecordError       a drop record that is malformed; `field` says where
├── JsonSyntaxError   text that is not JSON
├── JsonValueError    JSON with a value that is refused; `field` says where
└── ClusterError      workers elsewhere that cannot compute what is asked of them
"""


class EngineError(ValueError):
    """Root of all errors that the engine raises about its input."""

    def __init__(self, message: str, *, field: str = "") -> None:
        super().__init__(message)
        self.field = field


class BoardError(EngineError):
    """A board that cannot be played. `field` is its path in the JSON form, as `pegs[3].radius`."""


class EffortError(EngineError):
    """It takes more computing than whoever runs this process allows one call; see `limit_calls`."""


class SeedError(EngineError):
    """A seed that is not an integer 0 <= seed < 2^64."""


class ParameterError(EngineError):
    """A parameter of a solver, a drop or a world that is out of range."""


class RecordError(EngineError):
    """A drop record that lacks a field or holds one of the wrong type."""


class JsonSyntaxError(EngineError):
    """Text that is not JSON, or is nested too deeply."""


class JsonValueError(EngineError):
    """JSON with a key given twice, or a value that has no one meaning. `field` is its place."""


class ClusterError(EngineError):
    """Workers elsewhere that cannot compute: nobody answers, there are none, or they differ."""
