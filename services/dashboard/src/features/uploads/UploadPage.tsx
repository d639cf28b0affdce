import { Button, Group, Stack, Text, Title } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { infoQuery } from "@/api/queries";
import { LinkButton } from "@/app/links";
import { Page } from "@/app/Page";
import { say, sayFailure } from "@/app/say";
import { useStore } from "@/app/store";
import { SegmentForm } from "@/features/segmentation/SegmentForm";
import { bytes } from "@/format/format";
import { DropArea } from "./DropArea";
import { gather, type Picked } from "./gather";
import { UploadList } from "./UploadList";
import { uploads } from "./uploads";
import classes from "./uploads.module.css";
import { VolumeShelf } from "./VolumeShelf";

export function UploadPage() {
  const items = useStore(uploads.items);
  const info = useQuery(infoQuery);

  const recent = items.flatMap((item) => (item.assetId ? [item.assetId] : []));

  const take = async (picked: Picked[]) => {
    try {
      const { parcels, leftOut } = await gather(picked);
      if (leftOut.length > 0) {
        const some = leftOut.slice(0, 3).join(", ") + (leftOut.length > 3 ? ", …" : "");
        say(leftOut.length === 1 ? "One file was left out" : `${leftOut.length} files were left out`, some);
      }
      await uploads.add(parcels);
    } catch (error) {
      sayFailure("The files could not be read", error);
    }
  };

  return (
    <Page
      title="Upload and segment"
      lead="A T1 volume after contrast, and if you have it the one before. Meshes and motions are taken as well."
    >
      <div className={classes.columns}>
        <Stack gap="md">
          <DropArea
            onPicked={(picked) => void take(picked)}
            limit={info.data ? bytes(info.data.max_upload_bytes) : undefined}
          />
          {items.length > 0 && (
            <section>
              <Group justify="space-between" mb="xs">
                <Title order={2}>Uploads</Title>
                {items.some((item) => item.state === "done") && (
                  <Button size="compact-sm" variant="subtle" color="gray" onClick={() => uploads.clearDone()}>
                    Clear finished
                  </Button>
                )}
              </Group>
              <UploadList items={items} />
              <Group justify="space-between" mt="xs">
                <Text size="xs" c="dimmed">
                  Uploads go on while you look at other pages.
                </Text>
                {recent.length > 2 && (
                  <LinkButton to="/batches/new" size="compact-sm" variant="light">
                    Segment these as a batch
                  </LinkButton>
                )}
              </Group>
            </section>
          )}
          <VolumeShelf except={recent} />
        </Stack>
        <SegmentForm recent={recent} />
      </div>
    </Page>
  );
}
