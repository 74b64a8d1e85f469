"""What all schemas share."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, Field

MAX_CELLS = 255
"""Most rows and columns of a grid of items, and most targets of a behaviour."""
Row = Annotated[int, Field(strict=True, ge=0, le=MAX_CELLS)]
Column = Annotated[int, Field(strict=True, ge=0, le=MAX_CELLS)]
Cell = tuple[Row, Column]
"""(row from the bottom, column from the left), from 0."""

Id = Annotated[int, Field(strict=True, ge=1, le=2**31 - 1)]


class Schema(BaseModel):
    """Base: unknown fields are refused, rows can be read by attribute."""

    model_config = ConfigDict(extra="forbid", from_attributes=True)

    @classmethod
    def of(cls, source: object, /, **values: Any) -> Self:
        """Build one from these values and, for the other fields, an object's attributes."""
        names = cls.model_fields.keys() - values.keys()
        return cls.model_validate({name: getattr(source, name) for name in names} | values)
