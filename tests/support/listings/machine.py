"""Run the functions of a filled listing on symbols, through all answers to their comparisons.

`SymbolicMachine.explore` runs a specification and a function of the listing side by side, for each combination of answers. Both must
have the same effects: values that are stored, values that a loop carries, and results. specification.py has the specifications.

- A comparison of two values is a question, with the same answer wherever the same values are compared. Nothing follows from one answer
  for another comparison: not (a < b) is not b <= a, since either may be NaN.
- A loop over the components runs once, for the component i. What it changes of the values around it is a symbol in it, and another one
  after it. So a loop may carry one value only.
- An array that is a result may be the array of a parameter (u may be x). So after a value is stored, nothing is read from an array, but
  for the result itself at the component i, in a later loop of a law that scales u.
- Kernels that evaluate splines (OPAQUE) give symbols. They take nothing but the place in the segment and the weights of this place: of
  other inputs nothing is known here, and rounding.py bounds their rounding for these inputs alone. The other kernels are run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, NamedTuple

from tests.support.listings.field import PRIME, Symbols, element
from tests.support.listings.reader import (
    KINDS_OF_VALUES,
    PREFIX,
    Block,
    Expression,
    Function,
    Listing,
    Statement,
    UnknownMeaning,
    require,
)

OPAQUE = ("segment", "segment_at_tick", "basis", "basis_rate", "edge_at")
LIBRARY = ("exponent", "mantissa", "log", "logf")  # functions of a real number of which nothing else is known
LONGEST_EXPLORATION = 4096  # combinations of answers


class Value(NamedTuple):
    """value_type: "real", "int", "uint" with an element of the field; "bool"; or "status" with its name."""

    value_type: str
    content: Any


class Array(NamedTuple):
    """An array that is a parameter. role: its name in the specification."""

    role: str
    is_result: bool


@dataclass(frozen=True)
class Variable:
    """value: None until there is one."""

    value_type: str
    value: Any
    is_constant: bool


@dataclass
class Path:
    """One combination of answers: what is answered, and the effects so far."""

    answers: dict[Any, bool]
    symbols: Symbols
    effects: list[Any] = field(default_factory=list)
    carried_values: int = 0
    has_stored: bool = False
    has_stored_in_loop: bool = False

    def ask(self, *question: Any) -> bool:
        return self.answers.setdefault(question, True)

    def is_less(self, a: int, b: int, sign: str = "<") -> bool:
        return self.ask(sign, a % PRIME, b % PRIME)

    def is_finite(self, value: int) -> bool:
        return self.ask("finite", value)

    def carry(self, value_type: str) -> Any:
        """Return a value that a loop carries: first that in the body, then that after the loop."""
        self.carried_values += 1
        if value_type == "bool":
            return self.ask("carried", self.carried_values)
        return self.symbols.symbol("carried", self.carried_values)

    def restart(self) -> list[Any]:
        """Return the effects so far, and forget them: another run with the same answers follows."""
        effects, self.effects, self.carried_values = self.effects, [], 0
        self.has_stored = self.has_stored_in_loop = False
        return effects


Scope = dict[str, Variable | Array]
Action = Callable[[Path], None]


class SymbolicMachine:
    """words: the values of the words that fill the holes. scales: whether the law scales u in a loop of its own."""

    number_type, path_type, opaque = "real", Path, OPAQUE  # number_type: of entries of arrays

    def __init__(self, listing: Listing, symbols: Symbols, words: Mapping[str, Value], scales: bool = False) -> None:
        self.listing, self.symbols, self.words, self.scales = listing, symbols, words, scales
        self.i = symbols.symbol("i")
        self.bodies = {name: f.body for name, f in listing.functions.items() if name not in LIBRARY}

    def explore(self, name: str, specification: Action, action: Action) -> int:
        """Compare specification and listing for each combination of answers, and return how many there are."""
        pending: list[dict[Any, bool]] = [{}]
        for count in range(LONGEST_EXPLORATION):
            if not pending:
                return count
            answers = pending.pop()
            path = self.path_type(dict(answers), self.symbols)
            specification(path)
            wanted = path.restart()
            try:
                action(path)
            except UnknownMeaning as problem:
                raise UnknownMeaning(f"{name}: {problem}") from problem
            require(path.effects == wanted, f"{name} does not compute what it should")
            questions = list(path.answers.items())
            pending += [
                dict([*questions[:k], (questions[k][0], not questions[k][1])]) for k in range(len(answers), len(questions))
            ]
        raise UnknownMeaning(f"{name} has too many combinations of answers")

    # ---- functions

    def run(self, path: Path, name: str, arguments: Sequence[Value | Array]) -> None:
        """Run a public function. Its result, or its end, is the last effect."""
        function = self.listing.functions[name]
        passings = [
            (v.value_type, "value") if isinstance(v, Value) else (self.number_type, "result" if v.is_result else "array")
            for v in arguments
        ]
        require([(p.value_type, p.passing) for p in function.parameters] == passings, "it has other parameters than it should")
        scope: Scope = {
            p.name: v if isinstance(v, Array) else Variable(v.value_type, v.content, True)
            for p, v in zip(function.parameters, arguments, strict=True)
        }
        if not self._block(path, function, self.bodies[name], scope):
            require(function.result == "void", "it ends without a result")
            path.effects.append(("return", None))

    def kernel_results(self, path: Path, name: str, arguments: Sequence[Value]) -> list[Value]:
        """Run a kernel, and return its results: what it returns, or its outputs in order."""
        function = self.listing.functions[name]
        inputs = [p for p in function.parameters if p.passing == "value"]
        outputs = [p for p in function.parameters if p.passing == "output"]
        require(function.is_kernel and [*inputs, *outputs] == [*function.parameters], f"{name} is no kernel")
        require([p.value_type for p in inputs] == [v.value_type for v in arguments], f"{name} gets other arguments")
        require((not outputs) == (function.result != "void"), f"{name} has no results")
        scope: Scope = {p.name: Variable(p.value_type, v.content, True) for p, v in zip(inputs, arguments, strict=True)}
        results: dict[str, Value] = {}
        wanted = {p.name: p.value_type for p in outputs} or {"return": function.result}
        for item in self.bodies[name]:
            require(isinstance(item, Statement) and item.kind in ("define", "output", "return"), f"{name} has a block")
            assert isinstance(item, Statement)
            target = "return" if item.kind == "return" else item.target
            if item.kind == "define":
                require("return" not in results, f"{name} goes on behind its result")
                self._statement(path, function, item, scope)
            else:
                require(target in wanted and target not in results, f"{name} has a result twice: {item.text}")
                results[target] = Value(wanted[target], self._typed(path, item.value, scope, wanted[target]))
        require(results.keys() == wanted.keys(), f"{name} lacks a result")
        return [results[target] for target in wanted]

    # ---- statements

    def _block(self, path: Path, function: Function, body: Sequence[Statement | Block], scope: Scope) -> bool:
        """Run statements, and return whether they end the function."""
        for item in body:
            if isinstance(item, Statement):
                self._statement(path, function, item, scope)
                if item.kind == "return":
                    return True
            elif item.index:
                self._loop(path, function, item, scope)
            elif self._typed_operand(item.condition, scope, "bool"):
                require(self._block(path, function, item.body, dict(scope)), f"a branch goes on: {item.head}")
                return True
        return False

    def _statement(self, path: Path, function: Function, statement: Statement, scope: Scope) -> None:
        """Run a statement: give a value to a name in the scope, or add an effect to the path."""
        kind, target, text = statement.kind, statement.target, statement.text
        if kind in ("declare", "define"):
            require(target not in scope and statement.value_type != "void" and target not in self.words, f"a name twice: {text}")
            value = None if kind == "declare" else self._typed(path, statement.value, scope, statement.value_type)
            scope[target] = Variable(statement.value_type, value, statement.is_constant)
        elif kind == "assign":
            variable = scope.get(target)
            is_variable = isinstance(variable, Variable) and not variable.is_constant
            require(is_variable, f"this cannot be assigned: {text}")
            assert isinstance(variable, Variable)
            scope[target] = replace(variable, value=self._typed(path, statement.value, scope, variable.value_type))
        elif kind == "store":
            array = scope.get(target)
            value = self._typed(path, statement.value, scope, self.number_type)
            is_result = isinstance(array, Array) and array.is_result
            require(is_result and self._typed_operand(statement.index, scope, "int") == self.i, f"no store may be here: {text}")
            assert isinstance(array, Array)
            path.effects.append(("store", array.role, value))
            path.has_stored = path.has_stored_in_loop = True
        elif kind == "return":
            require((statement.value is None) == (function.result == "void"), f"another result: {text}")
            value = statement.value and self._typed(path, statement.value, scope, function.result)
            path.effects.append(("return", value))
        else:
            require(
                kind == "call" and self._value(path, statement.value, scope).value_type == "void", f"a value without use: {text}"
            )

    def _loop(self, path: Path, function: Function, loop: Block, scope: Scope) -> None:
        """Run the body once, for the component i."""
        count, index = self.words.get(loop.count), loop.index
        require(count is not None and count == self.words["number_n"], f"a loop over other components: {loop.head}")
        require(all(isinstance(item, Statement) for item in loop.body), f"a block in a loop: {loop.head}")
        targets = {item.target for item in loop.body if isinstance(item, Statement) and item.kind == "assign"}
        changed = sorted(targets & {name for name, v in scope.items() if isinstance(v, Variable)})
        require(targets == {*changed} and len(changed) < 2, f"a loop that carries two values: {loop.head}")
        require(index not in scope and index not in self.words, f"a name twice: {loop.head}")
        inner: Scope = {**scope, index: Variable("int", self.i, True)}
        for name in changed:
            inner[name] = self._carried(path, scope[name])
        path.has_stored_in_loop = False
        require(not self._block(path, function, loop.body, inner), f"a result within a loop: {loop.head}")
        for name in changed:
            path.effects.append(("carried", self._content(scope[name]), self._content(inner[name])))
            scope[name] = self._carried(path, scope[name])

    @staticmethod
    def _carried(path: Path, variable: Variable | Array) -> Variable:
        assert isinstance(variable, Variable)
        return replace(variable, value=path.carry(variable.value_type))

    @staticmethod
    def _content(variable: Variable | Array) -> Any:
        assert isinstance(variable, Variable)
        return variable.value

    # ---- expressions

    def _operand(self, text: str, scope: Scope) -> Value:
        """Return the value of a name or of a literal."""
        variable = scope.get(text)
        if isinstance(variable, Variable):
            require(variable.value is not None, f"{text} has no value")
            return Value(variable.value_type, variable.value)
        if text in self.words:
            return self.words[text]
        if text in ("true", "false"):
            return Value("bool", text == "true")
        if text == f"( {PREFIX}_real ) NAN":
            return Value("real", self.symbols.symbol("nan"))
        if text.startswith(f"{PREFIX.upper()}_"):
            return Value("status", text)
        literal = text.removeprefix("( ").removesuffix(" )").replace(" ", "")
        require(literal.lstrip("-").replace(".", "", 1).isdecimal(), f"{text} has no value")
        return Value("real" if "." in literal else "int", element(Fraction(literal)))

    def _typed_operand(self, text: str, scope: Scope, value_type: str) -> Any:
        value = self._operand(text, scope)
        require(value.value_type == value_type, f"{text} is {value.value_type} and not {value_type}")
        return value.content

    def _typed(self, path: Path, expression: Expression | None, scope: Scope, value_type: str) -> Any:
        value = self._value(path, expression, scope)
        require(value.value_type == value_type, f"{expression} is {value.value_type} and not {value_type}")
        return value.content

    def _value(self, path: Path, expression: Expression | None, scope: Scope) -> Value:
        """Return the value of an expression. Comparisons ask the path."""
        assert expression is not None
        match expression:
            case Expression("operand", (text,)):
                return self._operand(text, scope)
            case Expression("call", (name, arguments)):
                return self._call(path, name, arguments.split(" , "), scope)
            case Expression("load", (array, index)):
                return Value(self.number_type, self._load(path, array, self._typed_operand(index, scope, "int"), scope))
            case Expression("finite", (text,)):
                return Value("bool", path.is_finite(self._typed_operand(text, scope, "real")))
            case Expression("choice", (condition, first, second)):
                choices = [self._operand(text, scope) for text in (first, second)]
                require(choices[0].value_type == choices[1].value_type, f"a choice between two types: {expression}")
                return choices[0] if self._typed_operand(condition, scope, "bool") else choices[1]
            case Expression("cast", (target_type, text)):
                return self._cast(KINDS_OF_VALUES[target_type], self._operand(text, scope))
            case Expression("not", (text,)):
                return Value("bool", not self._typed_operand(text, scope, "bool"))
            case Expression("negation", (text,)):
                return Value(self.number_type, -self._typed_operand(text, scope, self.number_type) % PRIME)
            case Expression("operation", (first, sign, second)):
                return self._operation(path, sign, self._operand(first, scope), self._operand(second, scope))
        raise UnknownMeaning(f"this is no expression: {expression}")

    def _cast(self, target_type: str, value: Value) -> Value:
        match (value.value_type, target_type):
            case ("real", "int"):
                return Value("int", self.symbols.symbol("truncated", value.content))
            case ("int", "real"):
                return Value("real", self.symbols.real_from_integer(value.content))
            case ("uint", "int"):
                return Value("int", value.content)
        raise UnknownMeaning(f"a cast from {value.value_type} to {target_type}")

    def _operation(self, path: Path, sign: str, a: Value, b: Value) -> Value:
        """Return the result of a sign between two values of one type."""
        value_type = a.value_type
        require(
            value_type == b.value_type and (value_type == "bool") == (sign == "&&"),
            f"{sign} of {a.value_type} and {b.value_type}",
        )
        if sign == "&&":
            return Value("bool", a.content and b.content)
        if sign in ("<", "<="):
            require(value_type in ("real", "int", "uint"), f"a comparison of {value_type}")
            return Value("bool", path.is_less(a.content, b.content, sign))
        require(value_type in ("real", "int"), f"{sign} of {value_type}")
        calculate = self.symbols.real_operation if value_type == "real" else self.symbols.integer_operation
        return Value(value_type, calculate(sign, a.content, b.content))

    def _load(self, path: Path, array: str, index: int, scope: Scope) -> int:
        """Return an entry of an array or a table. Only a kernel that evaluates splines reads the coefficients."""
        parameter, table = scope.get(array), array.removeprefix(f"{PREFIX}_")
        if isinstance(parameter, Array):
            is_scaled_u = parameter.is_result and self.scales and path.has_stored and not path.has_stored_in_loop
            is_allowed = not (path.has_stored or parameter.is_result) or is_scaled_u
            require(is_allowed and index == self.i, f"{array} is read where it may not be")
            return self.symbols.symbol(f"load {parameter.role}", index)
        require(parameter is None and table != array and table in self.listing.tables, f"{array} is no array")
        require(table == "coefficients" or index == self.i, f"{array} is read at another component")
        return self.symbols.symbol(f"load {table}", index)

    # ---- calls

    def _call(self, path: Path, name: str, arguments: Sequence[str], scope: Scope) -> Value:
        """Run a kernel, or give symbols for it; write its outputs to names that have no value yet."""
        inputs = [self._operand(text, scope) for text in arguments if text[0] != "&"]
        outputs = [text[2:] for text in arguments if text[0] == "&"]
        kernel = name.removeprefix(f"{PREFIX}_")
        require(name not in scope and (kernel != name) == (name not in ("log", "logf")), f"a call of {name}")
        if kernel in LIBRARY:
            require([v.value_type for v in inputs] == ["real"] and not outputs, f"{name} gets other arguments")
            return Value("int" if kernel == "exponent" else "real", self.symbols.symbol(kernel.rstrip("f"), inputs[0].content))
        function = self.listing.functions.get(kernel)
        require(function is not None and function.is_kernel, f"a call of {name}")
        assert function is not None
        are_outputs = [p.passing == "output" for p in function.parameters]
        require([text[0] == "&" for text in arguments] == are_outputs, f"{name} gets its arguments in another order")
        results = self._opaque(kernel, inputs) if kernel in self.opaque else self.kernel_results(path, kernel, inputs)
        if function.result != "void":
            require(not outputs, f"{name} has no outputs")
            return results[0]
        require(len(outputs) == len({*outputs}) == len(results), f"{name} has other outputs")
        for target, value in zip(outputs, results, strict=True):
            require(scope.get(target) == Variable(value.value_type, None, False), f"{target} cannot be an output of {name}")
            scope[target] = Variable(value.value_type, value.content, False)
        return Value("void", None)

    def _opaque(self, kernel: str, inputs: Sequence[Value]) -> list[Value]:
        """Return symbols for the results of a kernel that evaluates splines. `UnknownMeaning` where it gets anything else than time,
        the place of this time, an index of this segment, or the weights of this place in their order."""
        symbol = self.symbols.symbol
        row, s = Value("int", symbol("row")), Value("real", symbol("s"))
        weights = {
            k: [Value("real", symbol(f"{letter}{j}")) for j in range(4)] for k, letter in (("basis", "w"), ("basis_rate", "dw"))
        }
        match kernel:
            case "segment" | "segment_at_tick":
                time = Value("real", symbol("t")) if kernel == "segment" else Value("uint", symbol("tick"))
                require([*inputs] == [time], f"{kernel} gets another time")
                return [row, s]
            case "basis" | "basis_rate":
                require([*inputs] == [s], f"{kernel} gets something else than the place in the segment")
                return weights[kernel]
        order = next((name for name, values in weights.items() if [*inputs[1:]] == values), None)
        lower = self.symbols.integer_operation("+", row.content, self.symbols.integer_operation("*", self.i, 2))
        side = {lower: "L", self.symbols.integer_operation("+", lower, 1): "U"}.get(inputs[0].content)
        require(order is not None, f"{kernel} gets something else than the weights in their order")
        require(
            side is not None and inputs[0].value_type == "int", f"{kernel} gets an index that is not of this component's edges"
        )
        return [Value("real", symbol(f"{side}{'' if order == 'basis' else chr(39)}"))]
