import { TextInput } from "@mantine/core";
import { useDebouncedCallback } from "@mantine/hooks";
import { Search } from "lucide-react";
import { useState } from "react";

/** A field for a text in names, which is told once one has stopped to write. */
export function NameFilter({ name, onName }: { name: string | undefined; onName: (name: string | undefined) => void }) {
  const [text, setText] = useState(name ?? "");
  const [known, setKnown] = useState(name);
  const [told, setTold] = useState(name);
  const tell = useDebouncedCallback((value: string) => {
    const next = value.trim() || undefined;
    setTold(next);
    onName(next);
  }, 250);
  // Somebody else may have changed it, as a link does that takes all filters away.
  if (name !== known) {
    setKnown(name);
    if (name !== told) {
      setText(name ?? "");
      setTold(name);
    }
  }
  return (
    <TextInput
      type="search"
      aria-label="Text in the name"
      placeholder="Name"
      leftSection={<Search size={15} aria-hidden="true" />}
      maxLength={255}
      value={text}
      onChange={(event) => {
        setText(event.currentTarget.value);
        tell(event.currentTarget.value);
      }}
    />
  );
}
