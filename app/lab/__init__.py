"""The lab: the method in the browser, in one file. Python writes the file; engine/ and view/ are what runs in it."""
