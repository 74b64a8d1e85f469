"""Games being played: at 60 Hz, over a WebSocket, saved as they go."""
