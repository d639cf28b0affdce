import { Paper, Progress, Stack, Text, Title } from "@mantine/core";
import { useInfiniteQuery, useQuery } from "@tanstack/react-query";
import { Link, useNavigate } from "@tanstack/react-router";
import { useState } from "react";
import { infoQuery } from "@/api/queries";
import { shapesQuery } from "@/api/shapes";
import { LinkAnchor } from "@/app/links";
import { Failure } from "@/app/Notice";
import { Page } from "@/app/Page";
import { useStore } from "@/app/store";
import { DropArea } from "@/features/uploads/DropArea";
import { gather, type Picked } from "@/features/uploads/gather";
import { uploads } from "@/features/uploads/uploads";
import { bytes, percent } from "@/format/format";
import { ShapePicture } from "./ShapePicture";
import classes from "./shape.module.css";
import wall from "./shapes.module.css";

const SHOWN = 12;

/** A search without an example yet: a file to drop, or one of the newest shapes. */
export function SearchStart() {
  const navigate = useNavigate();
  const info = useQuery(infoQuery);
  const shapes = useInfiniteQuery(shapesQuery({}));
  const items = useStore(uploads.items);
  const [sent, setSent] = useState<string | null>(null);
  const [error, setError] = useState<unknown>(null);
  const item = items.find(({ id }) => id === sent);
  const some = shapes.data?.pages[0]?.items.slice(0, SHOWN) ?? [];
  const take = async (picked: readonly Picked[]) => {
    setError(null);
    try {
      const { parcels } = await gather(picked.slice(0, 1));
      const ids = await uploads.add(parcels);
      setSent(ids[0] ?? null);
      const [done] = await uploads.settled(ids);
      if (done?.assetId) void navigate({ to: "/shapes/search", search: { asset: done.assetId } });
      else if (done?.error) setError(new Error(`${done.error.message} ${done.error.hint}`.trim()));
    } catch (thrown) {
      setError(thrown);
    } finally {
      setSent(null);
    }
  };
  return (
    <Page title="Search by example" lead="Give a mesh, or part of one, and see what resembles it.">
      <Stack gap="xl">
        {error !== null && <Failure error={error} />}
        {item ? (
          <Paper p="lg">
            <Text size="sm" mb={6}>
              Uploading {item.name}
            </Text>
            <Progress
              value={(100 * item.sent) / (item.size || 1)}
              aria-label={`${percent(item.sent / (item.size || 1))} sent`}
            />
          </Paper>
        ) : (
          <DropArea
            title="Drop a mesh here"
            says="OBJ, PLY, STL, OFF or GLB. It is searched with, and not added to the shapes."
            folders={false}
            limit={info.data ? bytes(info.data.max_upload_bytes) : undefined}
            onPicked={(picked) => void take(picked)}
          />
        )}
        {shapes.data && some.length === 0 && (
          <Text size="sm" c="dimmed">
            The bank is empty: there is nothing to be found in it yet.{" "}
            <LinkAnchor to="/shapes" underline="always">
              Add shapes
            </LinkAnchor>{" "}
            first.
          </Text>
        )}
        {some.length > 0 && (
          <section aria-labelledby="newest">
            <Title order={2} id="newest" mb="sm">
              Or take one of the newest
            </Title>
            <ul className={classes.newest}>
              {some.map((shape) => (
                <li key={shape.id}>
                  <Link to="/shapes/search" search={{ shape: shape.id }} className={wall.card}>
                    <ShapePicture shape={shape} />
                    <span className={wall.name} title={shape.name}>
                      {shape.name || "Without a name"}
                    </span>
                  </Link>
                </li>
              ))}
            </ul>
            <Text size="sm" c="dimmed" mt="md">
              Any other: open it from{" "}
              <LinkAnchor to="/shapes" underline="always">
                all shapes
              </LinkAnchor>
              , and choose Find similar.
            </Text>
          </section>
        )}
      </Stack>
    </Page>
  );
}
