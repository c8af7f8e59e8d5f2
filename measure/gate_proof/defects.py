"""Small defects that can be put into a Python module, each a span of its text replaced by another.

The text around the span stays as it is, so that lines keep their numbers. Places where a change cannot be seen are left
out: annotations, texts for people, what only a type checker reads, how a class keeps its fields.
"""

from __future__ import annotations

import ast
import hashlib
import io
import tokenize
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

Span = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Defect:
    """One small change.

    Attributes:
        id: the same as long as the function and the changed line are.
        path: the module's, within the tree.
        kind: what was done, such as "comparison".
        where: the function or class around it.
        line: the first line that is changed.
        lines: all lines of the changed expression; the first line of its statement is the last of them.
        in_function: it runs when a function is called, not when the module is imported.
        start: the offset of the replaced bytes.
        before: what is replaced.
        after: by what.
    """

    id: str
    path: str
    kind: str
    where: str
    line: int
    lines: tuple[int, ...]
    in_function: bool
    start: int
    before: str
    after: str

    def put_into(self, source: bytes) -> bytes:
        """Return the module with the defect."""
        before = self.before.encode()
        end = self.start + len(before)
        if source[self.start : end] != before:
            message = f"{self.path}: {self.before!r} is not where it was"
            raise ValueError(message)
        return source[: self.start] + self.after.encode() + source[end:]

    def matters(self, source: bytes) -> bool:
        """Whether the module still compiles, and to something else."""
        try:
            changed = _meaning(self.put_into(source))
        except (SyntaxError, ValueError):
            return False
        return changed != _meaning(source)


def _meaning(source: bytes) -> str:
    compile(source, "module", "exec", dont_inherit=True)
    return ast.dump(ast.parse(source))


class Text:
    """The bytes of a module, found by nodes and tokens."""

    def __init__(self, source: bytes) -> None:
        self.source = source
        self._lines = source.splitlines(keepends=True)
        self._starts = [0]
        for line in self._lines:
            self._starts.append(self._starts[-1] + len(line))
        self._tokens = [
            (self._at(token.start), self._at(token.end), token.string)
            for token in tokenize.generate_tokens(io.StringIO(source.decode(), newline="").readline)
            if token.type in {tokenize.OP, tokenize.NAME}
        ]

    def _at(self, place: tuple[int, int]) -> int:
        row, column = place
        if row > len(self._lines):
            return len(self.source)
        return self._starts[row - 1] + len(self._lines[row - 1].decode()[:column].encode())

    def span(self, node: ast.expr | ast.stmt) -> Span:
        """Return where a node begins and ends."""
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return self._starts[node.lineno - 1] + node.col_offset, self._starts[node.end_lineno - 1] + node.end_col_offset

    def of(self, span: Span) -> str:
        """Return the text of a span."""
        return self.source[span[0] : span[1]].decode()

    def words(self, start: int, end: int, wanted: str) -> Span | None:
        """Return where an operator of one or two words stands between two places."""
        parts = wanted.split()
        inside = [token for token in self._tokens if start <= token[0] and token[1] <= end]
        for first, token in enumerate(inside):
            if [each[2] for each in inside[first : first + len(parts)]] == parts:
                return token[0], inside[first + len(parts) - 1][1]
        return None

    def line(self, number: int) -> str:
        """Return a line, stripped."""
        return self._lines[number - 1].decode().strip()


@dataclass(frozen=True, slots=True)
class Edit:
    """A span and what replaces it."""

    kind: str
    span: Span
    after: str


Edits = Iterator[Edit]

COMPARISONS: dict[type[ast.cmpop], tuple[str, str]] = {
    ast.Lt: ("<", "<="),
    ast.LtE: ("<=", "<"),
    ast.Gt: (">", ">="),
    ast.GtE: (">=", ">"),
    ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="),
    ast.Is: ("is", "is not"),
    ast.IsNot: ("is not", "is"),
    ast.In: ("in", "not in"),
    ast.NotIn: ("not in", "in"),
}
ARITHMETIC: dict[type[ast.operator], tuple[str, str]] = {
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.Mult: ("*", "/"),
    ast.Div: ("/", "*"),
    ast.FloorDiv: ("//", "*"),
    ast.Mod: ("%", "*"),
    ast.LShift: ("<<", ">>"),
    ast.RShift: (">>", "<<"),
    ast.BitAnd: ("&", "|"),
    ast.BitOr: ("|", "&"),
    ast.BitXor: ("^", "&"),
}
NAMES = {"min": "max", "max": "min", "any": "all", "all": "any"}
METHODS = {"startswith": "endswith", "endswith": "startswith", "lstrip": "rstrip", "rstrip": "lstrip"}
ANY_ORDER = {"isinstance", "issubclass", "getattr", "hasattr", "setattr", "print", "zip", "hypot", "gcd", *NAMES}
BUILT_IN_TYPES = {
    "int",
    "str",
    "bytes",
    "bytearray",
    "float",
    "bool",
    "dict",
    "list",
    "tuple",
    "set",
    "frozenset",
    "type",
}


def _compare(node: ast.Compare, text: Text) -> Edits:
    ends = [node.left, *node.comparators]
    for operator, left, right in zip(node.ops, ends, ends[1:], strict=False):
        before, after = COMPARISONS[type(operator)]
        if span := text.words(text.span(left)[1], text.span(right)[0], before):
            yield Edit("comparison", span, after)


def _binary(node: ast.BinOp, text: Text) -> Edits:
    if type(node.op) not in ARITHMETIC or _is_text(node) or (isinstance(node.op, ast.BitOr) and _is_type(node)):
        return
    before, after = ARITHMETIC[type(node.op)]
    if span := text.words(text.span(node.left)[1], text.span(node.right)[0], before):
        yield Edit("mask" if isinstance(node.op, ast.BitAnd | ast.BitOr | ast.BitXor) else "arithmetic", span, after)


def _augmented(node: ast.AugAssign, text: Text) -> Edits:
    if type(node.op) in ARITHMETIC and not _is_words(node.value):
        before, after = ARITHMETIC[type(node.op)]
        if span := text.words(text.span(node.target)[1], text.span(node.value)[0], f"{before}="):
            yield Edit("assignment in place", span, f"{after}=")
    yield from _removed(node, text)


def _boolean(node: ast.BoolOp, text: Text) -> Edits:
    before, after = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
    if span := text.words(text.span(node.values[0])[1], text.span(node.values[1])[0], before):
        yield Edit("and, or", span, after)


def _unary(node: ast.UnaryOp, text: Text) -> Edits:
    start, _ = text.span(node)
    operand, _ = text.span(node.operand)
    if isinstance(node.op, ast.Not) and (span := text.words(start, operand, "not")):
        yield Edit("not", (span[0], span[1] + 1), "")
    elif isinstance(node.op, ast.USub) and (span := text.words(start, operand, "-")):
        yield Edit("sign", span, "+")


def _constant(node: ast.Constant, text: Text) -> Edits:
    span = text.span(node)
    if isinstance(node.value, bool):
        yield Edit("truth", span, str(not node.value))
    elif isinstance(node.value, int):
        written = text.of(span)
        yield Edit("whole number", span, _next(node.value, written))
    elif isinstance(node.value, float):
        yield Edit("number", span, repr(node.value * 2 if node.value else 1.0))


def _next(value: int, written: str) -> str:
    """Return the next number, written like this one; of a mask, one with another lowest bit."""
    if written.lower().startswith("0x"):
        return f"0x{value ^ 1:0{len(written) - 2}X}"
    if written.lower().startswith("0b"):
        return f"0b{value ^ 1:0{len(written) - 2}b}"
    return f"{value + 1:_}" if "_" in written else str(value + 1)


def _call(node: ast.Call, text: Text) -> Edits:
    name = _name(node.func)
    if isinstance(node.func, ast.Name) and name in NAMES:
        yield Edit("min, max, any, all", text.span(node.func), NAMES[name])
    if isinstance(node.func, ast.Attribute) and name in METHODS:
        _, end = text.span(node.func)
        yield Edit("end of a text", (end - len(name), end), METHODS[name])
    if name not in ANY_ORDER and len(node.args) > 1:
        yield from _swapped(node.args[0], node.args[1], text)


def _swapped(first: ast.expr, second: ast.expr, text: Text) -> Edits:
    if isinstance(first, ast.Starred) or isinstance(second, ast.Starred):
        return
    one, two = text.span(first), text.span(second)
    if text.of(one) != text.of(two):
        yield Edit("arguments swapped", (one[0], two[1]), text.of(two) + text.of((one[1], two[0])) + text.of(one))


def _condition(test: ast.expr, text: Text) -> Edits:
    if not isinstance(test, ast.Constant):
        span = text.span(test)
        yield Edit("condition negated", span, f"not ({text.of(span)})")


def _branch(node: ast.If | ast.While | ast.IfExp, text: Text) -> Edits:
    yield from _condition(node.test, text)


def _filter(node: ast.comprehension, text: Text) -> Edits:
    for test in node.ifs:
        yield from _condition(test, text)


def _return(node: ast.Return, text: Text) -> Edits:
    if node.value is not None and not isinstance(node.value, ast.Constant):
        yield Edit("value not returned", text.span(node.value), "None")


def _leave(node: ast.Break | ast.Continue, text: Text) -> Edits:
    yield Edit("break, continue", text.span(node), "continue" if isinstance(node, ast.Break) else "break")


def _slice(node: ast.Slice, text: Text) -> Edits:
    for bound in (node.lower, node.upper):
        if bound is not None and not isinstance(bound, ast.Constant):
            span = text.span(bound)
            yield Edit("slice", span, f"({text.of(span)}) + 1")


def _removed(node: ast.stmt, text: Text) -> Edits:
    yield Edit("statement removed", text.span(node), "pass")


def _assigned(node: ast.Assign, text: Text) -> Edits:
    if all(isinstance(target, ast.Attribute | ast.Subscript) for target in node.targets):
        yield from _removed(node, text)


def _called(node: ast.Expr, text: Text) -> Edits:
    value = node.value.value if isinstance(node.value, ast.Await) else node.value
    if isinstance(value, ast.Call) and not _does_nothing(value):
        yield from _removed(node, text)


def _does_nothing(call: ast.Call) -> bool:
    """Whether it is ``super().__init__()`` of a class that has no other base worth a name."""
    return _name(call.func) == "__init__" and not call.args and not call.keywords


OPERATORS: dict[type[ast.AST], Callable[..., Edits]] = {
    ast.Compare: _compare,
    ast.BinOp: _binary,
    ast.AugAssign: _augmented,
    ast.BoolOp: _boolean,
    ast.UnaryOp: _unary,
    ast.Constant: _constant,
    ast.Call: _call,
    ast.If: _branch,
    ast.While: _branch,
    ast.IfExp: _branch,
    ast.comprehension: _filter,
    ast.Return: _return,
    ast.Break: _leave,
    ast.Continue: _leave,
    ast.Slice: _slice,
    ast.Assign: _assigned,
    ast.Expr: _called,
    ast.Raise: _removed,
}


def _name(node: ast.expr) -> str:
    """Return the last word of a dotted name."""
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""


def _is_words(node: ast.expr) -> bool:
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str | bytes))


def _is_text(node: ast.BinOp) -> bool:
    """Whether texts or lists are put together: another operator would only be an error of types."""
    sides = (node.left, node.right)
    return any(
        _is_words(side) or isinstance(side, ast.List | ast.Tuple) or (isinstance(side, ast.BinOp) and _is_text(side))
        for side in sides
    )


def _is_type(node: ast.expr) -> bool:
    """Whether it names types, as in ``int | None``."""
    if isinstance(node, ast.BinOp):
        return _is_type(node.left) or _is_type(node.right)
    if isinstance(node, ast.Constant):
        return node.value is None
    name = _name(node.value if isinstance(node, ast.Subscript) else node)
    return name in BUILT_IN_TYPES or (name[:1].isupper() and not name.isupper())


NO_ORDINARY_CALLS = {
    "cast",
    "TypeVar",
    "NewType",
    "ParamSpec",
    "namedtuple",
    "warn",
    "warning",
    "debug",
    "info",
}
"""Calls whose arguments say nothing that a test could see."""
KEYWORDS = {"daemon", "slots", "frozen", "kw_only", "repr", "stacklevel", "flush", "maxsize", "buffering"}
DEFINITIONS = {"__all__", "__slots__", "__match_args__"}
OUTLINES = {"overload", "abstractmethod"}
UNSEEN: dict[type[ast.AST], tuple[str, ...]] = {
    ast.arg: ("annotation",),
    ast.AnnAssign: ("annotation",),
    ast.FunctionDef: ("returns", "decorator_list"),
    ast.AsyncFunctionDef: ("returns", "decorator_list"),
    ast.ClassDef: ("decorator_list", "keywords", "bases"),
    ast.Raise: ("exc", "cause"),
}
"""What of a node is not looked at."""


def _is_left_out(node: ast.AST, path: str) -> bool:
    match node:
        case ast.JoinedStr():
            return True
        case ast.Assert():
            return not path.startswith("hilbench/suites/")  # elsewhere it tells the type checker what is known
        case ast.FunctionDef(decorator_list=decorators) | ast.AsyncFunctionDef(decorator_list=decorators):
            return any(_name(decorator) in OUTLINES for decorator in decorators)
        case ast.Assign(targets=[ast.Name(id=name)]):
            return name in DEFINITIONS
        case ast.Call(func=function):
            return _name(function) in NO_ORDINARY_CALLS
        case ast.keyword(arg=name):
            return name in KEYWORDS
        case ast.If(test=test):
            return ast.unparse(test) in {"TYPE_CHECKING", "typing.TYPE_CHECKING", "__name__ == '__main__'"}
    return False


@dataclass(frozen=True, slots=True)
class _Place:
    """Where a node stands."""

    names: tuple[str, ...] = ()
    in_function: bool = False
    statement: int = 1


@dataclass(slots=True)
class _Search:
    path: str
    text: Text
    found: list[tuple[Edit, _Place, int, int]] = field(default_factory=list)

    def look(self, node: ast.AST, place: _Place) -> None:
        """Take all edits of a node and of what is in it."""
        if _is_left_out(node, self.path):
            return
        if isinstance(node, ast.stmt):
            place = _Place(place.names, place.in_function, node.lineno)
        if type(node) in OPERATORS:
            for edit in OPERATORS[type(node)](node, self.text):
                first, last = _lines(node, edit, self.text)
                self.found.append((edit, place, first, last))
        for name, value in ast.iter_fields(node):
            if name not in UNSEEN.get(type(node), ()):
                for child in value if isinstance(value, list) else [value]:
                    if isinstance(child, ast.AST):
                        self.look(child, _inside(node, name, place))


def _inside(node: ast.AST, part: str, place: _Place) -> _Place:
    if isinstance(node, ast.ClassDef) and part == "body":
        return _Place((*place.names, node.name), place.in_function, place.statement)
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
        return _Place((*place.names, node.name), place.in_function or part == "body", place.statement)
    return place


def _lines(node: ast.AST, edit: Edit, text: Text) -> tuple[int, int]:
    """Return the first and the last line of an edit, or of its node where that is smaller."""
    first = text.source.count(b"\n", 0, edit.span[0]) + 1
    last = text.source.count(b"\n", 0, edit.span[1]) + 1
    return first, min(last, getattr(node, "end_lineno", None) or last)


def defects_of(path: str, source: bytes) -> list[Defect]:
    """Return all small defects that can be put into a module, in the order of its text.

    Args:
        path: the module's, within the tree.
        source: its text.
    """
    text = Text(source)
    search = _Search(path, text)
    search.look(ast.parse(source), _Place())
    seen: Counter[tuple[str, ...]] = Counter()
    found = []
    for edit, place, first, last in sorted(search.found, key=lambda one: (one[0].span, one[0].after)):
        where, before = ".".join(place.names), text.of(edit.span)
        key = (path, where, edit.kind, text.line(first), before, edit.after)
        name = hashlib.sha256("\n".join([*key, str(seen[key])]).encode()).hexdigest()[:10]
        seen[key] += 1
        lines = (*range(first, last + 1), place.statement)
        found.append(
            Defect(name, path, edit.kind, where, first, lines, place.in_function, edit.span[0], before, edit.after)
        )
    return found


def lines_in_functions(source: bytes) -> frozenset[int]:
    """Return the lines that run when a function is called."""
    found: set[int] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            found.update(range(node.body[0].lineno, (node.end_lineno or node.lineno) + 1))
    return frozenset(found)


def names_imported(source: bytes) -> Sequence[str]:
    """Return the modules that a module imports, as dotted names, and what it takes from each as if it were one."""
    found: list[str] = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return found
