"""Words that pages explain."""

from __future__ import annotations

from pathlib import Path

from flexhex.output.glossary import TERMS


def test_words_are_explained_as_in_the_glossary() -> None:
    """docs/glossary.md has each sentence, whatever marks it wears."""
    root = Path(__file__).resolve().parents[2]
    text = (root / "docs" / "glossary.md").read_text(encoding="utf-8").replace("`", "")
    missing = {word: said for word, said in TERMS.items() if said not in text}
    assert missing == {}
