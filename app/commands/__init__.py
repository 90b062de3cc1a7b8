"""What a visitor can do, a class each: parsed once, then carried out on the page's model. No widgets, no waiting."""
