"""How functions that only kernels call are compiled: not at all on their own.

numba compiles every function by itself, optimises it, turns it into machine code and wraps it for
Python and for C, before it does all that again with what calls it. Here a function is only
translated; what calls it takes the translation in, and is optimised as a whole. That saves a third
of the time that a first run compiles.
"""

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder, _LowerResult
from numba.core.compiler_machinery import FunctionPass, LoweringPass, register_pass
from numba.core.typed_passes import NativeLowering
from numba.core.untyped_passes import IRProcessing


class _Translation(JITCodeLibrary):
    """A function's translation, and those of what it calls, neither optimised nor loaded."""

    def _optimize_final_module(self):
        pass

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True


@register_pass(mutates_CFG=False, analysis_only=False)
class _BeginTranslation(FunctionPass):
    _name = "begin_translation"

    def __init__(self):
        FunctionPass.__init__(self)

    def run_pass(self, state):
        codegen = state.targetctx.codegen()
        state.library = _Translation(codegen, state.func_id.func_qualname)
        state.flags.no_compile = True
        return False


@register_pass(mutates_CFG=False, analysis_only=False)
class _EndTranslation(LoweringPass):
    _name = "end_translation"

    def __init__(self):
        LoweringPass.__init__(self)

    def run_pass(self, state):
        result = state["cr"]
        # numba knows a function by its entry for Python. There is none, but there must be something
        # that is callable, and this function's alone.
        entry = [].clear
        state.library.finalize()
        state.targetctx.insert_user_function(entry, result.fndesc, [state.library])
        state["cr"] = _LowerResult(result.fndesc, result.call_helper, cfunc=entry, env=result.env)
        return True


class InnerCompiler(CompilerBase):
    """numba's own way, but that it ends before anything is optimised."""

    def define_pipelines(self):
        """Add to the passes what puts the translation in the place of the finished code."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.add_pass_after(_BeginTranslation, IRProcessing)
        passes.add_pass_after(_EndTranslation, NativeLowering)
        passes.finalize()
        return [passes]
