"""Database rows as the schemas show them."""
