// Nothing: its target holds the headers that all tests read precompiled.
