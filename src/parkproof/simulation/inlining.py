"""A short way from Python to machine code for kernels and the functions inlined into them.

numba compiles each function as if someone might call it from Python: it is optimised with all that
it calls, and turned into machine code of its own. Of the eighty functions that a kernel is made of
none is called but in the kernel. Here they are only translated, and the kernel, into which they
have been put, is optimised, once. Passes for what none of them has (closures, expressions of
arrays, literal loops) are left out, and so is what `inspect_types` would print. A kernel is
compiled in a third of the time that numba would take by itself. numba's settings for optimisation
(``NUMBA_OPT``, ``NUMBA_LOOP_VECTORIZE``) do not count for kernels.

numba documents pipelines of one's own (`numba.core.compiler.CompilerBase`); the two libraries and
`Operators` override methods that it does not document, hence the narrow range of versions that the
package asks for.
"""

import gc
from typing import Any

from llvmlite.binding import create_pass_builder, create_pipeline_tuning_options
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import NativeLowering

from parkproof.simulation.instructions import Instructions
from parkproof.simulation.single import SingleConstants

LEFT_OUT = (
    "WithLifting", "InlineClosureLikes", "RewriteDynamicRaises", "MakeFunctionToJitFunction",
    "InlineInlinables", "FindLiterallyCalls", "LiteralUnroll", "LiteralPropagationSubPipelinePass",
    "InlineOverloads", "NopythonRewrites", "NoPythonSupportedFeatureValidation", "AnnotateTypes",
    "DumpParforDiagnostics", "IRLegalization",
)  # fmt: skip
"""Passes of numba's pipeline that find nothing to do in these functions."""


class _AsTranslated(JITCodeLibrary):
    """Code that is not optimised function by function: a kernel is, with all that is in it."""

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout


class InlinedLibrary(_AsTranslated):
    """Code of a function that is only inlined."""

    @property
    def codegen(self) -> Any:
        """What would be told where a function's Python objects are; these have none."""
        return _NoEnvironments()

    def finalize(self) -> None:
        """Leave it as it is."""
        self._finalized = True

    def alone(self) -> Any:
        """Its code, for kernels, which link what it calls themselves."""
        return super()._get_module_for_linking()

    def _get_module_for_linking(self) -> Any:
        """Its code with that of all that it calls, for functions that numba compiles as usual."""
        whole = self.alone().clone()
        for library in self._linking_libraries:
            whole.link_in(library._get_module_for_linking(), preserve=True)
        return whole


class _NoEnvironments:
    """Takes notice of environments in place of the code generator."""

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing: machine code that would read it is never made."""


class KernelLibrary(_AsTranslated):
    """Code of a kernel, optimised in one go: there are no references to count beforehand."""

    def finalize(self) -> None:
        """Link each function once, after one that calls it; then go on.

        What has been linked before anything calls it would be left out.
        """
        left, known, others = list(self._linking_libraries), set[Any](), []
        while left:
            library = left.pop(0)
            if library in known:
                continue
            known.add(library)
            if isinstance(library, InlinedLibrary):
                self._final_module.link_in(library.alone(), preserve=True)
                left += library._linking_libraries
            else:
                others.append(library)
        self._linking_libraries = others
        super().finalize()

    def _optimize_final_module(self) -> None:
        options = create_pipeline_tuning_options(3)
        options.loop_vectorization, options.slp_vectorization = True, False
        # else short loops over the lanes of a group are unrolled before they are looked at for
        # vector instructions, and then have none
        options.loop_unrolling = False
        builder = create_pass_builder(self._codegen._tm, options)
        builder.getModulePassManager().run(self._final_module, builder)


_CALLS: dict[Any, Any] = {}
"""Signatures of calls, until a kernel is compiled; guarded by numba's lock of its compiler."""

_OPERATORS: dict[Any, Any] = {}
"""What operators become for types of operands, until a kernel is compiled; guarded likewise."""


class Operators(Lower):
    """Translates operators, looking only once for what each becomes for the same types.

    numba looks each time, and three times more for forms that know an operand, of which there are
    none here: a quarter of all the time in which functions were translated.
    """

    def lower_binop(self, resty: Any, expr: Any, op: Any) -> Any:
        """Code of an operator with two operands."""
        context, signature = self.context, self.fndesc.calltypes[expr]
        operands = [
            context.cast(self.builder, self.loadvar(each.name), self.typeof(each.name), wanted)
            for each, wanted in zip((expr.lhs, expr.rhs), signature.args, strict=True)
        ]
        if (op, signature.args) not in _OPERATORS:
            function = context.typing_context.resolve_value_type(op)
            found = function.get_call_type(context.typing_context, signature.args, {})
            _OPERATORS[op, signature.args] = context.get_function(function, found)
        result = _OPERATORS[op, signature.args](self.builder, operands)
        return context.cast(self.builder, result, signature.return_type, resty)


class _Lowering(NativeLowering):
    """Translates functions by way of `Operators`."""

    _name: Any = None

    @property
    def lowering_class(self) -> Any:
        """What translates their statements."""
        return Operators


@register_pass(mutates_CFG=True, analysis_only=False)
class LowerInlined(_Lowering):
    """Translate a function that is only inlined."""

    _name = "parkproof_lower_inlined"

    def run_pass(self, state: Any) -> Any:
        """Lower into a library that is only linked."""
        state.library = InlinedLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        return super().run_pass(state)


@register_pass(mutates_CFG=True, analysis_only=False)
class LowerKernel(_Lowering):
    """Translate a kernel."""

    _name = "parkproof_lower_kernel"

    def run_pass(self, state: Any) -> Any:
        """Lower into a library that is optimised once, and can be kept on disk."""
        state.library = KernelLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return super().run_pass(state)


def _pipeline(state: Any, lowering: type) -> PassManager:
    """Numba's own pipeline without what is left out, and with one branch pruning."""
    manager, seen = PassManager("inlining"), set[str]()
    for each, why in DefaultPassBuilder.define_nopython_pipeline(state).passes:
        name = each.__name__
        if name not in LEFT_OUT and name not in seen:
            manager.add_pass(lowering if name == "NativeLowering" else each, why)
        if name == "IRProcessing":
            manager.add_pass(SingleConstants, "written numbers are singles, too")
            manager.add_pass(Instructions, "no calls of max, min and int")
        seen.add(name)
    if not {"NativeLowering", "IRProcessing"} <= seen:
        raise RuntimeError("this version of numba has other passes than simulation/inlining.py")
    manager.finalize()
    return manager


class _Remembering:
    """numba's typing context, which finds what a call means only once for the same types.

    Of ten calls, most of them sums and products of doubles, nine have been there before.
    """

    def __init__(self, context: Any) -> None:
        self._context = context

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_function_type(self, function: Any, types: Any, options: Any) -> Any:
        """Signature of a call, or None."""
        call = function, types, tuple(options.items())
        if call not in _CALLS:
            found = self._context.resolve_function_type(function, types, options)
            if found is None:
                return None
            _CALLS[call] = found
        return _CALLS[call]


class _Compiler(CompilerBase):
    """What both compilers have in common."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.state.typingctx = _Remembering(self.state.typingctx)


class InlinedCompiler(_Compiler):
    """Compiler of functions that are only inlined."""

    def define_pipelines(self) -> list[Any]:
        """One pipeline."""
        return [_pipeline(self.state, LowerInlined)]


class KernelCompiler(_Compiler):
    """Compiler of kernels, whose arrays and buffers do not overlap."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        # else each loop over two of them would begin by comparing where they are
        self.state.flags.noalias = True

    def define_pipelines(self) -> list[Any]:
        """One pipeline."""
        return [_pipeline(self.state, LowerKernel)]

    def compile_extra(self, func: Any) -> Any:
        """Compile, without searches for garbage, which would look through millions of objects."""
        searching = gc.isenabled()
        gc.disable()
        try:
            return super().compile_extra(func)
        finally:
            _CALLS.clear()
            _OPERATORS.clear()
            if searching:
                gc.enable()
