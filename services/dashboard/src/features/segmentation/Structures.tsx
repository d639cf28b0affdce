import { Group, Paper, Text, Title } from "@mantine/core";
import type { ReactNode } from "react";
import classes from "./segmentation.module.css";

interface StructuresProps {
  id: string;
  /** Of the label that they have in the pictures. */
  color: string;
  title: string;
  /** What they are together. */
  says: string;
  children: ReactNode;
}

/** A table of what was found of one kind, under its color and its sum. */
export function Structures({ id, color, title, says, children }: StructuresProps) {
  return (
    <Paper p="md" component="section" aria-labelledby={id}>
      <Group justify="space-between" mb="xs">
        <Group gap="xs">
          <span className={classes.swatch} style={{ background: color }} aria-hidden="true" />
          <Title order={2} id={id}>
            {title}
          </Title>
        </Group>
        <Text size="sm" c="dimmed">
          {says}
        </Text>
      </Group>
      {children}
    </Paper>
  );
}
