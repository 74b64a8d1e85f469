"""What a game is made of, found by Tril itself, and what an order of games says in its terms."""
