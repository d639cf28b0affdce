import { Button, type ButtonProps } from "@mantine/core";
import { type ReactNode, useState } from "react";

interface SureProps extends Omit<ButtonProps, "children"> {
  /** What cannot be undone, as the second button says it. */
  sure: ReactNode;
  onSure: () => void;
  /** The first button, which only asks. */
  children: (ask: () => void) => ReactNode;
  "aria-label"?: string;
}

/** What cannot be undone takes two clicks: the second one on another button, which goes when it is left. */
export function Sure({ sure, onSure, children, ...button }: SureProps) {
  const [asked, setAsked] = useState(false);
  if (!asked) return children(() => setAsked(true));
  return (
    <Button color="red" autoFocus onBlur={() => setAsked(false)} onClick={onSure} {...button}>
      {sure}
    </Button>
  );
}
