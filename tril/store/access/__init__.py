"""Who gets in: signed-in browsers, keys, and invitations."""
