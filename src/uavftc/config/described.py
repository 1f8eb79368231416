"""What the keys of a section mean: the text below each field in its source.

pydantic can read these texts when a section is defined, but that takes 0.1 s of every flight. So they are read here,
when a page or a schema needs them.
"""

from __future__ import annotations

import ast
import inspect
import textwrap

from pydantic import BaseModel


def descriptions(section: type[BaseModel]) -> dict[str, str]:
    """Return the meaning of each key of a section, on one line; empty where its source says nothing."""
    texts: dict[str, str] = {}
    for model in reversed(section.__mro__):
        if issubclass(model, BaseModel) and model is not BaseModel:
            texts |= _below_fields(model)
    known = {name: field.description for name, field in section.model_fields.items() if field.description}
    return {name: " ".join((known.get(name) or texts.get(name, "")).split()) for name in section.model_fields}


def _below_fields(model: type[BaseModel]) -> dict[str, str]:
    try:
        source = textwrap.dedent(inspect.getsource(model))
    except (OSError, TypeError):  # made by create_model: its fields are those of its bases
        return {}
    body = ast.parse(source).body[0]
    if not isinstance(body, ast.ClassDef):
        return {}
    return {
        field.target.id: str(text.value.value)
        for field, text in zip(body.body, body.body[1:], strict=False)
        if isinstance(field, ast.AnnAssign)
        and isinstance(field.target, ast.Name)
        and isinstance(text, ast.Expr)
        and isinstance(text.value, ast.Constant)
        and isinstance(text.value.value, str)
    }
