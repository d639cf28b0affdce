import { ActionIcon, Collapse, CopyButton, Paper, Tabs, Text, Tooltip, UnstyledButton } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { Check, ChevronDown, ChevronRight, CodeXml, Copy } from "lucide-react";
import { useId, useState } from "react";
import { infoQuery } from "@/api/queries";
import classes from "./snippets.module.css";
import type { Snippets, Target } from "./snippets";

const LANGUAGES = [
  { value: "curl", label: "curl" },
  { value: "command", label: "Command line" },
  { value: "python", label: "Python" },
] as const;

interface AsCodeProps {
  title?: string;
  /** Makes the snippets for this server. */
  of: (target: Target) => Snippets;
  open?: boolean;
}

/** What the page is about to do, or has done, for those who would rather have it in a script. */
export function AsCode({ title = "The same as code", of, open: atFirst = false }: AsCodeProps) {
  const info = useQuery(infoQuery);
  const [open, setOpen] = useState(atFirst);
  const id = useId();
  const snippets = of({ server: window.location.origin, keyed: info.data?.auth === "keys" });
  return (
    <Paper component="section" aria-label={title}>
      <UnstyledButton
        className={classes.head ?? ""}
        aria-expanded={open}
        aria-controls={id}
        onClick={() => setOpen(!open)}
      >
        <CodeXml size={16} aria-hidden="true" />
        <span>{title}</span>
        {open ? <ChevronDown size={16} aria-hidden="true" /> : <ChevronRight size={16} aria-hidden="true" />}
      </UnstyledButton>
      <Collapse expanded={open} id={id}>
        <Tabs defaultValue="curl" px="md" pb="md" variant="pills" keepMounted={false}>
          <Tabs.List mb="xs">
            {LANGUAGES.map(({ value, label }) => (
              <Tabs.Tab key={value} value={value} size="xs" px={10} py={5}>
                {label}
              </Tabs.Tab>
            ))}
          </Tabs.List>
          {LANGUAGES.map(({ value }) => (
            <Tabs.Panel key={value} value={value} className={classes.panel ?? ""}>
              <pre className={classes.code} tabIndex={0} data-testid={`code-${value}`}>
                {snippets[value]}
              </pre>
              <CopyCode text={snippets[value]} />
            </Tabs.Panel>
          ))}
          {info.data?.auth === "keys" && (
            <Text size="xs" c="dimmed" mt="xs">
              Put your key into the environment first: <code>export SHAPERY_API_KEY=shp_…</code>
            </Text>
          )}
        </Tabs>
      </Collapse>
    </Paper>
  );
}

export function CopyCode({ text, label = "Copy" }: { text: string; label?: string }) {
  if (!navigator.clipboard) return null; // over plain HTTP from another machine: the text can still be marked
  return (
    <CopyButton value={text} timeout={1500}>
      {({ copied, copy }) => (
        <Tooltip label={copied ? "Copied" : label}>
          <ActionIcon
            variant="default"
            size={30}
            className={classes.copy ?? ""}
            aria-label={copied ? "Copied" : label}
            onClick={copy}
          >
            {copied ? <Check size={15} /> : <Copy size={15} />}
          </ActionIcon>
        </Tooltip>
      )}
    </CopyButton>
  );
}
