"""Docstrings of public names: numpydoc's own validation finds nothing missing in them."""

import importlib
import inspect
import pkgutil

import pytest

import viewimit

numpydoc = pytest.importorskip("numpydoc.validate")
CHECKS = {
    "GL08",  # no docstring
    "SS01",  # no summary
    "SS03",  # the summary does not end with a period
    "SS05",  # the summary begins with a third person
    "PR01",  # a parameter is not documented
    "PR02",  # a parameter is documented that does not exist
    "PR03",  # parameters are in another order
    "PR07",  # a parameter has no description
    "RT01",  # no Returns section
    "RT03",  # a return value has no description
    "GL07",  # sections are in the wrong order
}
FIELDS = {"PR01", "PR02", "PR03", "PR07"}  # of a class with fields: each is documented beside the field

OF_FIELDS = "__dataclass_fields__", "__struct_fields__", "__members__", "_is_protocol"  # marks of such classes


def protocols():
    """Every protocol of the library that a user may implement, by its dotted name."""
    for module in pkgutil.walk_packages(viewimit.__path__, "viewimit."):
        if module.name.split(".")[1] in ("app", "assets") or module.name.endswith("__main__"):
            continue
        for name, one in vars(importlib.import_module(module.name)).items():
            if getattr(one, "_is_protocol", False) and one.__module__ == module.name and not name.startswith("_"):
                yield f"{module.name}.{name}"


def members(dotted):
    """A public name, and the public methods that its class defines."""
    module, _, name = dotted.rpartition(".")
    one = getattr(importlib.import_module(module), name)
    yield dotted, one
    if inspect.isclass(one):
        for method, function in vars(one).items():
            if not method.startswith("_") and callable(getattr(function, "__func__", function)):
                yield f"{dotted}.{method}", function


PUBLIC = [f"viewimit.{name}" for name in viewimit.__all__ if callable(getattr(viewimit, name))]


@pytest.mark.parametrize("dotted", [*PUBLIC, *protocols()])
def test_public_docstrings_say_what_a_reader_needs(dotted):
    faults = []
    for name, one in members(dotted):
        asked = CHECKS - FIELDS if any(hasattr(one, mark) for mark in OF_FIELDS) else CHECKS
        faults += [f"{name}: {code} {text}" for code, text in numpydoc.validate(name)["errors"] if code in asked]
    assert not faults, "\n".join(faults)
