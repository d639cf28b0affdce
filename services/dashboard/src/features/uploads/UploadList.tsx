import { ActionIcon, Button, Group, Progress, Text, Tooltip } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { CircleAlert, CircleCheck, FileUp, FolderArchive, Pause, Play, RotateCw, X } from "lucide-react";
import { type ReactNode, useRef } from "react";
import { assetQuery } from "@/api/queries";
import { say } from "@/app/say";
import { Thumbnail } from "@/features/preview/Thumbnail";
import { describeAsset } from "@/format/asset";
import { bytes, duration, integer, percent } from "@/format/format";
import type { UploadItem } from "./manager";
import { uploads } from "./uploads";
import classes from "./uploads.module.css";
import { WhatFits } from "./WhatFits";

export function UploadList({ items }: { items: readonly UploadItem[] }) {
  return (
    <ul className={classes.list} aria-label="Uploads">
      {items.map((item) => (
        <UploadRow key={item.id} item={item} />
      ))}
    </ul>
  );
}

function UploadRow({ item }: { item: UploadItem }) {
  return (
    <li className={classes.row} data-state={item.state}>
      <Picture item={item} />
      <div style={{ minWidth: 0 }}>
        <Group gap="xs" wrap="nowrap">
          <StateIcon item={item} />
          <span className={classes.name} title={item.name}>
            {item.name}
          </span>
          <Text size="xs" c="dimmed" className={classes.size ?? ""}>
            {bytes(item.size)}
          </Text>
        </Group>
        {moves(item) && (
          <Progress
            value={item.size > 0 ? (item.sent / item.size) * 100 : 0}
            size={5}
            my={6}
            color={item.state === "waiting" ? "orange" : "petrol"}
            aria-label={`${item.name}: ${percent(item.size > 0 ? item.sent / item.size : 0)} sent`}
          />
        )}
        <Status item={item} />
      </div>
      <Actions item={item} />
    </li>
  );
}

function moves(item: UploadItem): boolean {
  return item.state !== "done" && item.state !== "failed" && item.state !== "needs-file";
}

/** What is in it, as long as it lies in the browser. */
function Picture({ item }: { item: UploadItem }) {
  const file = uploads.content(item.id);
  const Icon = item.files > 0 ? FolderArchive : FileUp;
  const icon = (
    <span className={classes.icon}>
      <Icon size={22} strokeWidth={1.5} aria-hidden="true" />
    </span>
  );
  if (!file || item.state === "failed") return icon;
  return (
    <Thumbnail id={item.id} name={item.name} file={file}>
      {icon}
    </Thumbnail>
  );
}

function StateIcon({ item }: { item: UploadItem }) {
  if (item.state === "done") return <CircleCheck size={16} color="var(--mantine-color-teal-6)" aria-label="Uploaded" />;
  if (item.state === "failed") return <CircleAlert size={16} color="var(--mantine-color-red-6)" aria-label="Failed" />;
  if (item.state === "needs-file") {
    return <CircleAlert size={16} color="var(--mantine-color-orange-6)" aria-label="Interrupted" />;
  }
  return null;
}

function Status({ item }: { item: UploadItem }) {
  const { data: asset } = useQuery({
    ...assetQuery(item.assetId ?? ""),
    enabled: item.assetId !== null,
  });
  const line = (content: ReactNode, color = "dimmed") => (
    <Text size="sm" c={color}>
      {content}
    </Text>
  );
  switch (item.state) {
    case "preparing":
      return line(`Putting ${integer(item.files)} files together…`);
    case "queued":
      return line("Waiting for its turn");
    case "sending": {
      const left = item.rate > 0 ? (item.size - item.sent) / item.rate : null;
      return line(
        item.sent >= item.size
          ? "Sent; the server looks at it"
          : [
              percent(item.size > 0 ? item.sent / item.size : 0),
              item.rate > 0 ? `${bytes(Math.round(item.rate))}/s` : "",
              left !== null && left > 3 ? `${duration(left)} left` : "",
            ]
              .filter(Boolean)
              .join(" · "),
      );
    }
    case "waiting":
      return line(`${item.error?.message ?? ""} It goes on by itself.`, "var(--warn)");
    case "paused":
      return line(`Paused at ${percent(item.size > 0 ? item.sent / item.size : 0)}`);
    case "needs-file":
      return line("The page was left before it was done. Choose the file again, and it goes on where it stopped.");
    case "failed":
      return (
        <Text size="sm" role="alert">
          <Text span size="sm" c="var(--bad)">
            {item.error?.message}
          </Text>{" "}
          <Text span size="sm" c="dimmed">
            {item.error?.hint}
          </Text>
        </Text>
      );
    case "done":
      return line(asset ? describeAsset(asset) : "Uploaded");
  }
}

function Actions({ item }: { item: UploadItem }) {
  const input = useRef<HTMLInputElement>(null);
  const { data: asset } = useQuery({ ...assetQuery(item.assetId ?? ""), enabled: item.assetId !== null });
  return (
    <Group gap={2} wrap="nowrap">
      {(item.state === "sending" || item.state === "waiting" || item.state === "queued") && (
        <Act label={`Pause ${item.name}`} onClick={() => uploads.pause(item.id)}>
          <Pause size={16} />
        </Act>
      )}
      {item.state === "paused" && (
        <Act label={`Continue ${item.name}`} onClick={() => uploads.resume(item.id)}>
          <Play size={16} />
        </Act>
      )}
      {item.state === "failed" && (
        <Act label={`Send ${item.name} again`} onClick={() => uploads.resume(item.id)}>
          <RotateCw size={16} />
        </Act>
      )}
      {item.state === "needs-file" && (
        <>
          <Button size="compact-sm" variant="default" onClick={() => input.current?.click()}>
            Choose
          </Button>
          <input
            ref={input}
            type="file"
            hidden
            aria-label={`Choose ${item.name} again`}
            onChange={(event) => {
              const file = event.currentTarget.files?.[0];
              event.currentTarget.value = "";
              if (!file) return;
              void uploads.continueWith(item.id, file).then((accepted) => {
                if (!accepted) {
                  say(
                    "Another file",
                    `${file.name} has ${bytes(file.size)}; the upload began with ${bytes(item.size)}.`,
                  );
                }
              });
            }}
          />
        </>
      )}
      {asset && <WhatFits asset={asset} />}
      <Act
        label={item.state === "done" ? `Clear ${item.name} from the list` : `Cancel ${item.name}`}
        onClick={() => void uploads.remove(item.id)}
      >
        <X size={16} />
      </Act>
    </Group>
  );
}

function Act({ label, onClick, children }: { label: string; onClick: () => void; children: ReactNode }) {
  return (
    <Tooltip label={label} openDelay={400}>
      <ActionIcon variant="subtle" color="gray" aria-label={label} onClick={onClick}>
        {children}
      </ActionIcon>
    </Tooltip>
  );
}
