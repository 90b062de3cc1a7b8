"""What explains the page: lessons, the help, the glossary's cards and the keys. What lessons and cards say is data, in
assets/."""
