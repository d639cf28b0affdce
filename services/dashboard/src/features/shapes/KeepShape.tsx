import { Autocomplete, Button, Popover, Stack } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { useNavigate } from "@tanstack/react-router";
import { Plus } from "lucide-react";
import { type SubmitEvent, useState } from "react";
import { collectionsQuery } from "@/api/shapes";
import type { Asset } from "@/api/types";
import { adding } from "./adder";

/** Puts the mesh that was searched with into the bank. */
export function KeepShape({ asset }: { asset: Asset }) {
  const navigate = useNavigate();
  const collections = useQuery(collectionsQuery);
  const [name, setName] = useState("");
  const [open, setOpen] = useState(false);
  const submit = (event: SubmitEvent) => {
    event.preventDefault();
    const collection = name.trim() || "default";
    void adding.index([asset.id], collection);
    void navigate({ to: "/shapes" });
  };
  return (
    <Popover position="bottom-end" width={280} trapFocus shadow="md" opened={open} onChange={setOpen}>
      <Popover.Target>
        <Button
          variant="default"
          leftSection={<Plus size={15} aria-hidden="true" />}
          onClick={() => setOpen(!open)}
          aria-expanded={open}
        >
          Add it to the shapes
        </Button>
      </Popover.Target>
      <Popover.Dropdown>
        <form onSubmit={submit}>
          <Stack gap="sm">
            <Autocomplete
              label="Collection"
              placeholder="default"
              maxLength={200}
              data={collections.data?.map((one) => one.name) ?? []}
              comboboxProps={{ withinPortal: false }}
              value={name}
              onChange={setName}
            />
            <Button type="submit" size="sm">
              Add
            </Button>
          </Stack>
        </form>
      </Popover.Dropdown>
    </Popover>
  );
}
