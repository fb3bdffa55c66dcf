"""The pages of `artrec studio`, made with NiceGUI: they show, and call what lies in `studio_state`."""
