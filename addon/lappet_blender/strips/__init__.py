"""The strip timeline: events as strips over the Timeline and the Dope Sheet, grouped by step."""
