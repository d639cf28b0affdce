import { Alert, Button, Paper, PasswordInput, Stack, Text, Title } from "@mantine/core";
import { useQueryClient } from "@tanstack/react-query";
import { KeyRound } from "lucide-react";
import { type SubmitEvent, useState } from "react";
import { signIn } from "@/api/session";

/** Asks for an API key: the server wants one, or did not take the one it was given. */
export function KeyGate({ refused }: { refused: boolean }) {
  const client = useQueryClient();
  const [key, setKey] = useState("");
  const submit = (event: SubmitEvent) => {
    event.preventDefault();
    const given = key.trim();
    if (!given) return;
    signIn(given);
    client.clear();
  };
  return (
    <Paper p="xl" mx="auto" mt={{ base: 40, sm: 96 }} w="min(26rem, calc(100% - 2.5rem))">
      <form onSubmit={submit}>
        <Stack>
          <Title order={1}>This server asks for a key</Title>
          <Text c="dimmed" size="sm">
            Whoever runs the server hands out API keys. Yours stays in this tab only, and is forgotten when you close
            it.
          </Text>
          {refused && (
            <Alert color="red" variant="light" role="alert">
              The key was not accepted: it is mistyped, has expired, or was revoked.
            </Alert>
          )}
          <PasswordInput
            label="API key"
            placeholder="shp_…"
            autoComplete="off"
            data-autofocus
            leftSection={<KeyRound size={16} />}
            value={key}
            onChange={(event) => setKey(event.currentTarget.value)}
          />
          <Button type="submit" disabled={!key.trim()}>
            Continue
          </Button>
        </Stack>
      </form>
    </Paper>
  );
}
