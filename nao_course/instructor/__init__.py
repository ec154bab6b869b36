"""What an instructor uses: plans of lessons, release, worker, grader and reports. No student code imports it."""
