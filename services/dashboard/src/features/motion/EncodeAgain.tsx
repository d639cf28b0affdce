import { Button, Group, Paper, Slider, Text, Title } from "@mantine/core";
import { useNavigate } from "@tanstack/react-router";
import { RotateCw } from "lucide-react";
import { useState } from "react";
import { Attempts } from "@/api/idempotency";
import { useCreateJob } from "@/api/queries";
import type { Job } from "@/api/types";
import { Failure } from "@/app/Notice";
import { bytes, significant } from "@/format/format";
import { rateAt, type RatePoint } from "./rate";

/** What the slider goes through: hundredths of a decade of the KG error. */
const [FINEST, COARSEST] = [0.02, 1];
const LAST = Math.round(100 * Math.log10(COARSEST / FINEST));
const toKg = (place: number) => Number((FINEST * 10 ** (place / 100)).toPrecision(2));
const toPlace = (kg: number) => Math.round(100 * Math.log10(Math.min(Math.max(kg, FINEST), COARSEST) / FINEST));
const MARKS = [0.02, 0.05, 0.1, 0.2, 0.5, 1];

interface EncodeAgainProps {
  job: Job;
  /** The KG error that was asked for or met, in percent. */
  kg: number;
  curve: readonly RatePoint[];
  /** Vertices times frames. */
  pairs: number;
  /** Told of the error that is pointed to. */
  onPoint: (kg: number) => void;
}

/** The same sequence at another quality. */
export function EncodeAgain({ job, kg: before, curve, pairs, onPoint }: EncodeAgainProps) {
  const navigate = useNavigate();
  const create = useCreateJob();
  const [attempts] = useState(() => new Attempts());
  const [place, setPlace] = useState(toPlace(before));
  const kg = toKg(place);
  const others = Object.entries(job.params).filter(([name]) => !["kg", "rmse", "max_error"].includes(name));
  const request = { kind: job.kind, inputs: job.inputs, params: { ...Object.fromEntries(others), kg } };
  const expected = rateAt(curve, kg);
  return (
    <Paper p="md" component="section" aria-labelledby="again">
      <Title order={3} id="again">
        Another quality
      </Title>
      <Text size="sm" mt="xs">
        KG error up to <b>{significant(kg, 2)} %</b>
      </Text>
      <Slider
        mt={4}
        mb="xl"
        thumbLabel="KG error"
        thumbValueText={(value) => `${significant(toKg(value), 2)} %`}
        label={null}
        min={0}
        max={LAST}
        value={place}
        marks={MARKS.map((mark) => ({ value: toPlace(mark), label: String(mark) }))}
        onChange={(next) => {
          setPlace(next);
          onPoint(toKg(next));
        }}
      />
      <Text size="sm" c="dimmed" mb="sm">
        {expected === null
          ? "How large that file will be is not known beforehand."
          : `About ${significant(expected, 2)} bits per vertex and frame: ${bytes((expected * pairs) / 8)}.`}
      </Text>
      {create.isError && <Failure error={create.error} />}
      <Group>
        <Button
          size="sm"
          variant="light"
          leftSection={<RotateCw size={15} aria-hidden="true" />}
          loading={create.isPending}
          onClick={() =>
            create.mutate(
              { request, idempotencyKey: attempts.keyFor(request) },
              { onSuccess: (next) => void navigate({ to: "/jobs/$jobId", params: { jobId: next.id } }) },
            )
          }
        >
          Compress again
        </Button>
      </Group>
    </Paper>
  );
}
