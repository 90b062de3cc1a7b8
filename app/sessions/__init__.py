"""What is kept of a visitor between two connections, and where: autosave, codec, stores, resume. The session itself is
the library's."""
