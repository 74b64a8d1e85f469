"""Single files that an archive holds as they are; they import nothing of Tril."""
