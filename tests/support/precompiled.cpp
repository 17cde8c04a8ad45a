// Empty: the precompiled header of the tests needs a file of its own to be made for.
