"""Many games stepped together by processes over shared memory."""
