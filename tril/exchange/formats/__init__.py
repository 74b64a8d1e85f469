"""File formats: one recording as a JSON object, many as JSON Lines, a whole behaviour.

See docs/exchange-format.md and docs/behaviour-format.md. ``python -m scripts.schemas`` prints their
JSON Schemas.
"""
