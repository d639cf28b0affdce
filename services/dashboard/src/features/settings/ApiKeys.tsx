import { Alert, Badge, Button, Group, Paper, Select, Stack, Table, Text, TextInput, Title } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { KeyRound, Plus } from "lucide-react";
import { type SubmitEvent, useState } from "react";
import { apiKeysQuery, useCreateKey, useRevokeKey } from "@/api/apiKeys";
import { ApiError } from "@/api/problem";
import { infoQuery } from "@/api/queries";
import type { Key, Scope } from "@/api/types";
import { Failure, Waiting } from "@/app/Notice";
import { sayFailure } from "@/app/say";
import { Sure } from "@/app/Sure";
import { useNow } from "@/app/useNow";
import { AsCode, CopyCode } from "@/features/snippets/AsCode";
import { keySnippets } from "@/features/snippets/snippets";
import { ago, moment } from "@/format/format";
import classes from "./settings.module.css";

const RIGHTS: { value: string; label: string; scopes: Scope[] }[] = [
  { value: "read", label: "Look only", scopes: ["read"] },
  { value: "write", label: "Look, upload and run", scopes: ["read", "write"] },
  { value: "admin", label: "Everything, also keys", scopes: ["read", "write", "admin"] },
];
const LIVES = [
  { value: "30", label: "30 days" },
  { value: "90", label: "90 days" },
  { value: "365", label: "A year" },
  { value: "", label: "Ever, until revoked" },
];

/** The keys of whoever is signed in: list, make, revoke. */
export function ApiKeys() {
  const info = useQuery(infoQuery);
  const all = useQuery({ ...apiKeysQuery, retry: false });
  const forbidden = all.error instanceof ApiError && all.error.status === 403;
  return (
    <Paper p="lg" component="section" aria-labelledby="keys">
      <Title order={2} id="keys">
        API keys
      </Title>
      <Text size="sm" c="dimmed" mb="md">
        {info.data?.auth === "local"
          ? "This server runs for this machine only and asks for no key. Keys made here count once it is run for others."
          : "Programs sign in with a key. A key reaches what its maker reaches, within its rights."}
      </Text>
      {forbidden ? (
        <Alert color="petrol" variant="light" icon={<KeyRound size={18} />}>
          Your key may not see or make keys. Ask whoever gave it to you.
        </Alert>
      ) : all.isPending ? (
        <Waiting label="Loading the keys…" />
      ) : all.isError && !all.data ? (
        <Failure error={all.error} onRetry={() => void all.refetch()} />
      ) : (
        <Stack gap="lg">
          <NewKey />
          <KeyTable keys={all.data.items} />
        </Stack>
      )}
    </Paper>
  );
}

function NewKey() {
  const create = useCreateKey();
  const [name, setName] = useState("");
  const [rights, setRights] = useState("write");
  const [days, setDays] = useState("90");
  const scopes = RIGHTS.find(({ value }) => value === rights)?.scopes ?? [];
  const submit = (event: SubmitEvent) => {
    event.preventDefault();
    if (!name.trim()) return;
    const expires = days ? new Date(Date.now() + Number(days) * 86_400_000).toISOString() : null;
    create.mutate({ name: name.trim(), scopes, expires_at: expires }, { onSuccess: () => setName("") });
  };
  return (
    <>
      <form onSubmit={submit}>
        <div className={classes.form}>
          <TextInput
            label="Name"
            placeholder="What the key is for"
            maxLength={100}
            value={name}
            onChange={(event) => setName(event.currentTarget.value)}
          />
          <Select
            label="Rights"
            data={RIGHTS.map(({ value, label }) => ({ value, label }))}
            allowDeselect={false}
            value={rights}
            onChange={(value) => setRights(value ?? "write")}
          />
          <Select
            label="Valid for"
            data={LIVES}
            allowDeselect={false}
            value={days}
            onChange={(value) => setDays(value ?? "")}
          />
          <Button
            type="submit"
            disabled={!name.trim()}
            loading={create.isPending}
            leftSection={<Plus size={16} aria-hidden="true" />}
          >
            Make a key
          </Button>
        </div>
      </form>
      {create.isError && <Failure error={create.error} />}
      {create.data && (
        <Alert color="teal" variant="light" icon={<KeyRound size={18} />} title={`The key “${create.data.name}”`}>
          <Text size="sm" mb="xs">
            It is shown this once. Copy it now: the server keeps a hash of it only.
          </Text>
          <div className={classes.secret}>
            <code data-testid="secret">{create.data.secret}</code>
            <CopyCode text={create.data.secret} label="Copy the key" />
          </div>
        </Alert>
      )}
      <AsCode of={(target) => keySnippets(name.trim() || "my key", scopes, days ? Number(days) : null, target)} />
    </>
  );
}

function KeyTable({ keys }: { keys: readonly Key[] }) {
  const now = useNow(30_000);
  if (keys.length === 0) {
    return (
      <Text size="sm" c="dimmed">
        There are no keys yet.
      </Text>
    );
  }
  return (
    <Table.ScrollContainer minWidth={520}>
      <Table verticalSpacing="xs">
        <Table.Thead>
          <Table.Tr>
            <Table.Th>Key</Table.Th>
            <Table.Th>Rights</Table.Th>
            <Table.Th>Used</Table.Th>
            <Table.Th>Valid until</Table.Th>
            <Table.Th>
              <span className={classes.unseen}>Actions</span>
            </Table.Th>
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {keys.map((key) => (
            <KeyRow key={key.id} apiKey={key} now={now} />
          ))}
        </Table.Tbody>
      </Table>
    </Table.ScrollContainer>
  );
}

function KeyRow({ apiKey: key, now }: { apiKey: Key; now: number }) {
  const revoke = useRevokeKey();
  const over = key.expires_at ? Date.parse(key.expires_at) < now : false;
  return (
    <Table.Tr>
      <Table.Td>
        <Text size="sm" fw={550}>
          {key.name}
        </Text>
        <Text size="xs" c="dimmed" ff="monospace">
          {key.prefix}…
        </Text>
      </Table.Td>
      <Table.Td>
        <Group gap={4}>
          {key.scopes.map((scope) => (
            <Badge key={scope} variant="default" tt="none" fw={500}>
              {scope}
            </Badge>
          ))}
        </Group>
      </Table.Td>
      <Table.Td>
        <Text size="sm" c="dimmed">
          {key.last_used_at ? ago(key.last_used_at, now) : "never"}
        </Text>
      </Table.Td>
      <Table.Td>
        <Text size="sm" c={over ? "var(--bad)" : "dimmed"}>
          {key.expires_at ? `${moment(key.expires_at)}${over ? ", is over" : ""}` : "it is revoked"}
        </Text>
      </Table.Td>
      <Table.Td ta="right">
        <Sure
          size="compact-sm"
          variant="light"
          sure="Revoke for good"
          aria-label={`Revoke for good ${key.name}`}
          loading={revoke.isPending}
          onSure={() => revoke.mutate(key.id, { onError: (error) => sayFailure("Not revoked", error) })}
        >
          {(ask) => (
            <Button
              size="compact-sm"
              variant="subtle"
              color="gray"
              loading={revoke.isPending}
              aria-label={`Revoke ${key.name}`}
              onClick={ask}
            >
              Revoke
            </Button>
          )}
        </Sure>
      </Table.Td>
    </Table.Tr>
  );
}
