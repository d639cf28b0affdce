import { Box, Breadcrumbs, Group, Text, Title } from "@mantine/core";
import { type ReactNode, useEffect } from "react";
import classes from "./Page.module.css";

interface PageProps {
  title: ReactNode;
  /** What it lies in, as links. */
  trail?: ReactNode;
  /** What the browser's tab says, where the title is not plain text. */
  tab?: string;
  lead?: ReactNode;
  actions?: ReactNode;
  children: ReactNode;
}

export function Page({ title, trail, tab, lead, actions, children }: PageProps) {
  const name = tab ?? (typeof title === "string" ? title : "");
  useEffect(() => {
    document.title = name ? `${name} · Shapery` : "Shapery";
  }, [name]);
  return (
    <Box className={classes.page ?? ""}>
      <Group justify="space-between" align="flex-end" mb="lg" gap="md">
        <div className={classes.heading}>
          {trail && (
            <Breadcrumbs mb={4} separatorMargin={6} fz="sm" c="dimmed">
              {trail}
            </Breadcrumbs>
          )}
          <Title order={1} className={classes.title ?? ""}>
            {title}
          </Title>
          {lead && (
            <Text component="div" c="dimmed" size="sm" mt={4}>
              {lead}
            </Text>
          )}
        </div>
        {actions}
      </Group>
      {children}
    </Box>
  );
}
