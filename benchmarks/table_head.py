"""The lines of a table in Markdown that stand above its rows."""

from __future__ import annotations


def table_head(title: str, heads: str) -> list[str]:
    """Title, heads and rule, three lines.

    Args:
        title: Above the table.
        heads: Between bars; one that ends in a colon stands over numbers.
    """
    columns = heads.split(" | ")
    names = " | ".join(head.removesuffix(":") for head in columns)
    marks = "|".join("---:" if head.endswith(":") else "---" for head in columns)
    return [f"**{title}**\n", f"| {names} |", f"|{marks}|"]
