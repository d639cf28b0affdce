import { ActionIcon, Button, Group, Text, Title, Tooltip } from "@mantine/core";
import { useMutation, useQuery, useQueryClient } from "@tanstack/react-query";
import { Box, Trash2 } from "lucide-react";
import { useState } from "react";
import { api, body } from "@/api/client";
import { keys, volumesQuery } from "@/api/queries";
import type { Asset } from "@/api/types";
import { Failure } from "@/app/Notice";
import { sayFailure } from "@/app/say";
import { Sure } from "@/app/Sure";
import { useNow } from "@/app/useNow";
import { describeAsset } from "@/format/asset";
import { ago, bytes, moment } from "@/format/format";
import classes from "./uploads.module.css";
import { WhatFits } from "./WhatFits";

const AT_FIRST = 6;

/** The volumes that lie on the server already, newest first; `except` are shown elsewhere on the page. */
export function VolumeShelf({ except }: { except: readonly string[] }) {
  const volumes = useQuery(volumesQuery);
  const [all, setAll] = useState(false);
  const now = useNow(30_000);
  if (volumes.isError && !volumes.data) return <Failure error={volumes.error} onRetry={() => void volumes.refetch()} />;
  const items = (volumes.data?.items ?? []).filter(({ id }) => !except.includes(id));
  if (items.length === 0) return null;
  return (
    <section aria-labelledby="shelf">
      <Title order={2} mb="xs" id="shelf">
        Volumes on the server
      </Title>
      <ul className={classes.list}>
        {(all ? items : items.slice(0, AT_FIRST)).map((volume) => (
          <Row key={volume.id} volume={volume} now={now} />
        ))}
      </ul>
      {items.length > AT_FIRST && (
        <Button variant="subtle" color="gray" size="compact-sm" mt={6} onClick={() => setAll(!all)}>
          {all ? "Show fewer" : `Show ${items.length - AT_FIRST} more`}
        </Button>
      )}
    </section>
  );
}

function Row({ volume, now }: { volume: Asset; now: number }) {
  const client = useQueryClient();
  const remove = useMutation({
    mutationFn: () =>
      body(
        api.DELETE("/v1/assets/{asset_id}", {
          params: { path: { asset_id: volume.id } },
        }),
      ),
    onError: (error) => sayFailure("Not deleted", error),
    onSettled: () => void client.invalidateQueries({ queryKey: keys.assetLists }),
  });
  return (
    <li className={classes.row}>
      <Box size={20} strokeWidth={1.5} aria-hidden="true" />
      <div style={{ minWidth: 0 }}>
        <Group gap="xs" wrap="nowrap" justify="space-between">
          <span className={classes.name} title={volume.filename}>
            {volume.filename}
          </span>
          <Text size="xs" c="dimmed" style={{ whiteSpace: "nowrap" }} title={moment(volume.created_at)}>
            {bytes(volume.size)} · {ago(volume.created_at, now)}
          </Text>
        </Group>
        <Text size="sm" c="dimmed">
          {describeAsset(volume)}
        </Text>
      </div>
      <Group gap={2} wrap="nowrap">
        <WhatFits asset={volume} />
        <Sure size="compact-sm" variant="light" sure="Delete" loading={remove.isPending} onSure={() => remove.mutate()}>
          {(ask) => (
            <Tooltip label="Delete" openDelay={400}>
              <ActionIcon variant="subtle" color="gray" aria-label={`Delete ${volume.filename}`} onClick={ask}>
                <Trash2 size={16} />
              </ActionIcon>
            </Tooltip>
          )}
        </Sure>
      </Group>
    </li>
  );
}
