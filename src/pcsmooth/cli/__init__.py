"""The command line: the only room that prints, and the only importer of click and tqdm."""
