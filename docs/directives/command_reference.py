"""Every command with its options, from the parsers themselves."""

import argparse

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from viewimit.commands import cli


class Commands(SphinxDirective):
    def run(self) -> list[nodes.Node]:
        found: list[nodes.Node] = []
        for name, text in cli.COMMANDS.items():
            section = nodes.section(ids=[f"viewimit-{name}"], names=[f"viewimit-{name}"])
            section += nodes.title("", f"viewimit {name}")
            section += nodes.paragraph("", text)
            parser = _subparsers(cli.parser_of(name))[name]
            section += _options(parser)
            for benchmark, its_parser in _subparsers(parser).items():
                section += nodes.paragraph("", "", nodes.literal("", f"viewimit {name} {benchmark}"))
                section += nodes.paragraph("", its_parser.description or "")
                section += _options(its_parser)
            found.append(section)
        return found


def _subparsers(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    found = (action.choices for action in parser._actions if isinstance(action, argparse._SubParsersAction))
    return next(found, {})


def _options(parser: argparse.ArgumentParser) -> nodes.definition_list:
    formatter = parser._get_formatter()
    listed = nodes.definition_list(classes=["options"])
    for action in parser._actions:
        if isinstance(action, (argparse._HelpAction, argparse._SubParsersAction)):
            continue
        metavar = (
            formatter._format_args(action, formatter._get_default_metavar_for_optional(action))
            if action.option_strings
            else formatter._metavar_formatter(action, action.dest)(1)[0]
        )
        words = " ".join([", ".join(action.option_strings), metavar]).strip() if action.option_strings else metavar
        item = nodes.definition_list_item()
        item += nodes.term("", "", nodes.literal(words, words))
        item += nodes.definition("", nodes.paragraph("", formatter._expand_help(action) if action.help else ""))
        listed += item
    return listed


def add_to(app: Sphinx) -> None:
    app.add_directive("commands", Commands)
