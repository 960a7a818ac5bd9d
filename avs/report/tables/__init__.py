"""Tables, one file each: from records to what is printed."""
