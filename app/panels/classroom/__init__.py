"""What a class adds to the page: the lecturer's tab, the students' banner and name, the question in a lesson. What
follows from them is in control/."""
