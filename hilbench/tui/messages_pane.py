"""The pane of messages: each with its rate and last fields; one of them field by field, and which are plotted."""

from __future__ import annotations

from collections.abc import Sequence

from rich.text import Text

from hilbench.tui.fields_pane import FieldsPane
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.frames import Field, MessageModel
from hilbench.tui.model.signals import field_signal
from hilbench.tui.views.messages import messages_view
from hilbench.tui.views.words import seconds

__all__ = ["MessagesPane"]


class MessagesPane(FieldsPane):
    """See the module; a message is known by what `FrameModel.message` says."""

    def __init__(self) -> None:
        super().__init__("messages")

    def things(self) -> list[MessageModel]:
        """See `FieldsPane`."""
        return [] if self.model is None else self.model.messages

    def name_of(self, thing: MessageModel) -> object:
        """See `FieldsPane`."""
        return thing.latest.message

    def fields_of(self, thing: MessageModel) -> Sequence[Field]:
        """See `FieldsPane`."""
        return thing.latest.fields

    def signal_of(self, thing: MessageModel, field: str) -> str:
        """See `FieldsPane`."""
        return field_signal(thing.latest, field)

    def title_of(self, thing: MessageModel, now_ns: int) -> tuple[str, str]:
        """See `FieldsPane`."""
        way = "sent" if thing.latest.sent else "heard"
        said = f"{way} {thing.count}x, {thing.per_s(now_ns):.1f}/s, last at {seconds(thing.latest.ns)}"
        return thing.latest.item.name, said

    def listed(self, model: BenchModel, width: int, height: int) -> list[Text]:
        """See `FieldsPane`."""
        return messages_view(model.messages, width, height, model.ns, chosen=self.chosen)

    def name_at(self, row: int) -> object:
        """See `FieldsPane`."""
        things = self.things()
        return self.name_of(things[row - 1]) if 1 <= row <= len(things) else None
