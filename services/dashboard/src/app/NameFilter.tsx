import { TextInput } from "@mantine/core";
import { useDebouncedCallback } from "@mantine/hooks";
import { Search } from "lucide-react";
import { useState } from "react";

/** A field for a text in names, which is told once one has stopped to write. */
export function NameFilter({ name, onName }: { name: string | undefined; onName: (name: string | undefined) => void }) {
  const [text, setText] = useState(name ?? "");
  const tell = useDebouncedCallback((value: string) => onName(value.trim() || undefined), 250);
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
