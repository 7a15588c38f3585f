"""The strip timeline: events as strips over the Timeline and the Dope Sheet, dragged, copied, muted, grouped by step."""
