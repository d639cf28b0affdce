import { ActionIcon, Tooltip } from "@mantine/core";
import type { LucideIcon } from "lucide-react";

interface ToolProps {
  /** What it does. */
  label: string;
  icon: LucideIcon;
  onClick: () => void;
  /** Whether it is on; a tool that does something once is neither. */
  on?: boolean;
  /** What it is called where several viewers have the same. */
  name?: string;
  disabled?: boolean;
}

/** A button in a viewer's bar. */
export function Tool({ label, icon: Icon, onClick, on, name = label, disabled = false }: ToolProps) {
  return (
    <Tooltip label={label} openDelay={400}>
      <ActionIcon
        variant={on ? "filled" : "default"}
        size={30}
        aria-label={name}
        aria-pressed={on}
        disabled={disabled}
        onClick={onClick}
      >
        <Icon size={16} aria-hidden="true" />
      </ActionIcon>
    </Tooltip>
  );
}
