"""How generation 2 draws its robots."""
