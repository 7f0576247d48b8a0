"""How numba compiles a kernel that only other kernels call: as far as they need it."""

from collections.abc import Callable
from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler


class _InnerLibrary(JITCodeLibrary):
    """Code that is there to be linked into callers, and becomes machine code only inside of them.

    Numba would optimize it, make machine code of it and keep that, then optimize it once more in
    every caller: a tenth of the time to compile.
    """

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalized = True


class InnerCompiler(Compiler):
    """Numba's compiler, stopping before the machine code; for functions that are not cached."""

    def compile_extra(self, function: Callable[..., object]) -> Any:
        """Compile `function`; callers know it by its entry point, as which any new object does."""
        context = self.state.targetctx
        library: Any = _InnerLibrary
        compile_it: Any = super().compile_extra
        self.state.library = library(context.codegen(), function.__qualname__)
        self.state.flags.no_compile = True
        found = compile_it(function)._replace(entry_point=object())
        context.insert_user_function(found.entry_point, found.fndesc, [found.library])
        return found
