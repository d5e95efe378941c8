"""``python -m scenewidget``: the command, where its script is not on the path."""

from scenewidget.command_line import main

if __name__ == "__main__":
    raise SystemExit(main())
