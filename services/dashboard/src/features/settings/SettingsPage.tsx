import { Paper, SegmentedControl, Stack, Text, Title, useMantineColorScheme } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { infoQuery, kindsQuery } from "@/api/queries";
import { Facts } from "@/app/Facts";
import { Failure } from "@/app/Notice";
import { Page } from "@/app/Page";
import { workName } from "@/features/jobs/naming";
import { bytes, duration, integer } from "@/format/format";
import { ApiKeys } from "./ApiKeys";
import classes from "./settings.module.css";

export function SettingsPage() {
  return (
    <Page title="Keys and settings">
      <div className={classes.columns}>
        <ApiKeys />
        <Stack gap="md">
          <Limits />
          <Appearance />
        </Stack>
      </div>
    </Page>
  );
}

/** What the server allows, and for how long it keeps things. */
function Limits() {
  const info = useQuery(infoQuery);
  const kinds = useQuery(kindsQuery);
  return (
    <Paper p="md" component="section" aria-labelledby="limits">
      <Title order={2} id="limits" mb="xs">
        Limits and retention
      </Title>
      {info.isError && !info.data && <Failure error={info.error} onRetry={() => void info.refetch()} />}
      {info.data && (
        <Facts
          rows={[
            ["Largest upload", bytes(info.data.max_upload_bytes)],
            ["Jobs in one batch", `up to ${integer(info.data.max_batch_items)}`],
            ["Results are kept", span(info.data.result_ttl_seconds)],
            ["Unfinished uploads are kept", span(info.data.upload_ttl_seconds)],
          ]}
        />
      )}
      {kinds.data && kinds.data.length > 0 && (
        <>
          <Title order={3} mt="md" mb={4}>
            One job may take
          </Title>
          <Facts
            rows={kinds.data.map(({ name, time_limit, memory_limit }) => [
              workName(name),
              `${duration(time_limit)}, ${bytes(memory_limit)}`,
            ])}
          />
        </>
      )}
    </Paper>
  );
}

/** A retention: whole days where it is that long. */
function span(seconds: number): string {
  const days = seconds / 86_400;
  if (days >= 2) return `${Math.round(days)} days`;
  return days === 1 ? "1 day" : duration(seconds);
}

function Appearance() {
  const { colorScheme, setColorScheme } = useMantineColorScheme();
  return (
    <Paper p="md" component="section" aria-labelledby="appearance">
      <Title order={2} id="appearance" mb="xs">
        Appearance
      </Title>
      <SegmentedControl
        fullWidth
        aria-label="Theme"
        data={[
          { value: "auto", label: "As the system" },
          { value: "light", label: "Light" },
          { value: "dark", label: "Dark" },
        ]}
        value={colorScheme}
        onChange={(value) => setColorScheme(value)}
      />
      <Text size="xs" c="dimmed" mt={6}>
        Kept in this browser.
      </Text>
    </Paper>
  );
}
