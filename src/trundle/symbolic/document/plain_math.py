"""LaTeX formulas as one line of text, for terminals."""

from __future__ import annotations

import re

_GREEK = (
    "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa",
    "lambda", "mu", "nu", "xi", "omicron", "pi", "rho", "varsigma", "sigma", "tau", "upsilon",
    "phi", "chi", "psi", "omega",
)  # fmt: skip
_SIGNS = {
    **{name: chr(0x3B1 + i) for i, name in enumerate(_GREEK)},
    "cdot": "·", "times": "×", "partial": "∂", "nabla": "∇", "sum": "Σ", "in": "∈", "ne": "≠",
    "le": "≤", "ge": "≥", "quad": "  ", "qquad": "    ", "|": "‖", "lbrace": "{", "rbrace": "}",
    "to": "→", "infty": "∞", "Rightarrow": "⇒", "dots": "...", "ldots": "...", "perp": "⊥",
    ",": " ", ";": " ", ":": " ", "!": "", " ": " ", "left": "", "right": "",
}  # fmt: skip
_RAISED = dict(zip("0123456789+-T*", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻ᵀ*", strict=True))
_LOWERED = dict(zip("0123456789+-aehijklmnoprstuvx", "₀₁₂₃₄₅₆₇₈₉₊₋ₐₑₕᵢⱼₖₗₘₙₒₚᵣₛₜᵤᵥₓ", strict=True))
_TOKEN = re.compile(r"\\([A-Za-z]+|.)|([{}^_])|(.)", re.DOTALL)
_DOTS = {"dot": "\u0307", "ddot": "\u0308", "hat": "\u0302", "bar": "\u0304"}
_FRACTIONS = ("frac", "tfrac", "dfrac")
_FUNCTIONS = ("sin", "cos", "tan")
_WORDS = ("text", "mathrm", "operatorname")


def plain_math(latex: str) -> str:
    r"""Return LaTeX as a line of text.

    >>> plain_math(r"\omega = \left(W^{T} W\right)^{-1} W^{T} \zeta_{12}")
    'ω = (Wᵀ W)⁻¹ Wᵀ ζ₁₂'
    >>> plain_math(r"\frac{\partial J}{\partial \omega} = 0")
    '∂J/∂ω = 0'
    """
    tokens = [match.group(0) for match in _TOKEN.finditer(latex)]
    text, _ = _read(tokens, 0, whole=True)
    text = re.sub(r"(?<=\S) {2}(?=\S)", " ", text).strip()
    # No space after a sign that belongs to what follows.
    text = re.sub(r"(^|[(\[,=] ?)- ", r"\1-", text)
    return text.replace("∂ ", "∂").replace("( ", "(").replace(" )", ")")


def plain_text(sentence: str) -> str:
    """Return sentences with the LaTeX between dollar signs as text.

    >>> plain_text("the radius $a_{1}$ of it")
    'the radius a₁ of it'
    """
    parts = sentence.split("$")
    return "".join(plain_math(part) if i % 2 else part for i, part in enumerate(parts))


def _read(tokens: list[str], at: int, whole: bool = False) -> tuple[str, int]:
    """Return a run of tokens as text, up to a closing brace, and where it ends."""
    out: list[str] = []
    while at < len(tokens) and (whole or tokens[at] != "}"):
        text, at = _item(tokens, at)
        out.append(text)
    return "".join(out), at


def _item(tokens: list[str], at: int) -> tuple[str, int]:
    token = tokens[at]
    if token == "{":
        text, end = _read(tokens, at + 1)
        return text, end + 1
    if token in "^_":
        text, at = _item(tokens, at + 1)
        return _shifted(text, _RAISED if token == "^" else _LOWERED, token), at
    if not token.startswith("\\"):
        return token, at + 1
    name = token[1:]
    if name in _FRACTIONS:
        top, at = _item(tokens, at + 1)
        bottom, at = _item(tokens, at)
        over = f"({top})" if _is_sum(top) else top
        return f"{over}/{_grouped(bottom)}", at
    if name in _DOTS:
        inner, at = _item(tokens, at + 1)
        return inner[:1] + _DOTS[name] + inner[1:], at
    if name == "sqrt":
        inner, at = _item(tokens, at + 1)
        return f"√{_grouped(inner)}", at
    if name in _WORDS:
        return _item(tokens, at + 1)
    if name in _FUNCTIONS and tokens[at + 1 : at + 2] not in (["{"], ["^"], ["\\left"]):
        return f"{name} ", at + 1
    return _SIGNS.get(name, name), at + 1


def _shifted(text: str, signs: dict[str, str], mark: str) -> str:
    if all(sign in signs for sign in text):
        return "".join(signs[sign] for sign in text)
    return f"{mark}{text}" if text.isalnum() else f"{mark}({text})"


def _is_sum(text: str) -> bool:
    return " + " in text or " - " in text.strip()


def _grouped(text: str) -> str:
    whole = text.strip().replace("∂ ", "∂")
    return f"({text})" if " " in whole or _is_sum(text) else text
