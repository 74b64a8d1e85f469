"""Vocabularies of games, made in a process of their own."""

from server.vocabularies.maker import Making, VocabularyMaker

__all__ = ["Making", "VocabularyMaker"]
