"""What the pages of a class do: a student's follows the lecturer's orders, the lecturer's gives them. How these get
from one to the other is not here."""
