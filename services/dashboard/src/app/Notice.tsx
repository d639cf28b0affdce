import { Alert, Button, Center, Group, Loader, Stack, Text, Title } from "@mantine/core";
import { CircleAlert, RotateCw, WifiOff } from "lucide-react";
import type { ReactNode } from "react";
import { connection } from "@/api/connection";
import { describe, Unreachable } from "@/api/problem";
import { useStore } from "./store";

/** Something did not work: what, why, and what to do about it. */
export function Failure({ error, onRetry }: { error: unknown; onRetry?: (() => void) | undefined }) {
  const { message, code, hint } = describe(error);
  const silent = error instanceof Unreachable;
  const down = useStore(connection) === "down";
  // That the server is silent stands above every page already, and all is asked for anew as soon as it answers.
  if (silent && down && onRetry) return <Waiting label="Waiting for the server…" />;
  return (
    <Alert
      color={silent ? "gray" : "red"}
      variant="light"
      icon={silent ? <WifiOff size={18} /> : <CircleAlert size={18} />}
      role="alert"
    >
      <Group justify="space-between" align="flex-start">
        <div>
          <Text size="sm" fw={550}>
            {message}
          </Text>
          {hint && <Text size="sm">{hint}</Text>}
          {code && !silent && (
            <Text size="xs" c="dimmed" ff="monospace" mt={4}>
              {code}
            </Text>
          )}
        </div>
        {onRetry && (
          <Button size="xs" variant="default" leftSection={<RotateCw size={14} />} onClick={onRetry}>
            Try again
          </Button>
        )}
      </Group>
    </Alert>
  );
}

/** Nothing is here yet, and what to do about it. */
export function Empty({ icon, title, children }: { icon: ReactNode; title: string; children?: ReactNode }) {
  return (
    <Center py={72} px="md">
      <Stack align="center" gap="xs" maw={440} ta="center">
        <Text c="dimmed">{icon}</Text>
        <Title order={2}>{title}</Title>
        {children}
      </Stack>
    </Center>
  );
}

export function Waiting({ label }: { label: string }) {
  return (
    <Center py={72} role="status">
      <Group gap="sm">
        <Loader size="sm" />
        <Text c="dimmed" size="sm">
          {label}
        </Text>
      </Group>
    </Center>
  );
}
